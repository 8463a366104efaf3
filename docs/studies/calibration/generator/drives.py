"""The lab's calibration drives: what a person would send to a robot to get to know it."""

from __future__ import annotations

import math

import numpy as np

Segment = tuple[float, float, float]
"""(v in m/s, omega in rad/s, duration in s)."""

Message = tuple[float, float, float]
"""(t in s, v in m/s, omega in rad/s)."""


def _sign(random: np.random.Generator) -> float:
    return float(random.choice([-1.0, 1.0]))


def lines(random: np.random.Generator) -> list[Segment]:
    """Straight lines at a slow, a middle and a fast speed, out and back, with stops."""
    segments: list[Segment] = []
    for speed in (0.05, 0.1, 0.16):
        v = speed * random.uniform(0.85, 1.15) * _sign(random)
        segments += [(v, 0.0, 1.5), (0.0, 0.0, 0.8), (-v, 0.0, 1.5), (0.0, 0.0, 0.8)]
    return segments


def turns(random: np.random.Generator) -> list[Segment]:
    """Turns in place, slow to fast, both ways."""
    segments: list[Segment] = []
    for rate in (0.6, 1.3, 2.3):
        omega = rate * random.uniform(0.85, 1.15) * _sign(random)
        segments += [(0.0, omega, 1.3), (0.0, 0.0, 0.8), (0.0, -omega, 1.3), (0.0, 0.0, 0.8)]
    return segments


def arcs(random: np.random.Generator) -> list[Segment]:
    """Arcs of several curvatures that follow each other without a stop, then the way back."""
    segments: list[Segment] = []
    for _ in range(3):
        v, omega = random.uniform(0.05, 0.14) * _sign(random), random.uniform(0.4, 2.0) * _sign(random)
        segments += [(v, omega, 2.0), (-v, omega, 1.6)]
    return [*segments, (0.0, 0.0, 0.8)]


def square(random: np.random.Generator) -> list[Segment]:
    """A square with a stop before and after each corner."""
    v, omega = random.uniform(0.07, 0.13), random.uniform(1.0, 2.0) * _sign(random)
    side: list[Segment] = [(v, 0.0, 1.5), (0.0, 0.0, 0.6), (0.0, omega, math.pi / 2 / abs(omega)), (0.0, 0.0, 0.6)]
    return side * 4


def eight(random: np.random.Generator) -> list[Segment]:
    """A figure of eight."""
    v, omega = random.uniform(0.08, 0.14), random.uniform(1.1, 1.6) * _sign(random)
    return [(v, omega, 2 * math.pi / abs(omega)), (v, -omega, 2 * math.pi / abs(omega)), (0.0, 0.0, 0.8)]


def starts(random: np.random.Generator) -> list[Segment]:
    """Many short starts from rest, straight and turning."""
    segments: list[Segment] = []
    for index in range(6):
        v = random.uniform(0.06, 0.14) * (1 if index % 2 else -1)
        omega = 0.0 if index < 4 else random.uniform(-1.5, 1.5)
        segments += [(v, omega, 0.9), (0.0, 0.0, 0.9)]
    return segments


def extremes(random: np.random.Generator) -> list[Segment]:
    """From a crawl to the wheels' limit, straight and turning."""
    speeds = np.array([0.006, 0.012, 0.02, 0.028, 0.036, 0.05, 0.13, 0.185]) * random.uniform(0.85, 1.08, 8)
    crawl: list[Segment] = [(float(v), 0.0, 1.0) for v in speeds]
    omega = random.uniform(1.8, 2.6) * _sign(random)
    return [*crawl, (-0.14, omega, 1.6), (0.0, 0.0, 0.8), (0.0, 0.5 * _sign(random), 1.0), (-0.15, 0.0, 1.0), (0.0, 0.0, 0.8)]


PIECES = (extremes, starts, lines, turns, square, arcs, eight)


def programme(random: np.random.Generator, number: int) -> list[list[Segment]]:
    """Drives of a log: each two pieces of the procedure, every piece in turn before any comes again.

    Args:
        random: Source of the speeds and of the order.
        number: Number of drives.

    Returns:
        For each drive its segments, the first and last at rest.
    """
    order: list[int] = []
    while len(order) < 2 * number:
        order += list(random.permutation(len(PIECES)))
    rest: list[Segment] = [(0.0, 0.0, 1.0)]
    return [rest + PIECES[order[2 * k]](random) + PIECES[order[2 * k + 1]](random) + rest for k in range(number)]


def messages(segments: list[Segment], random: np.random.Generator, resend: float | None) -> list[Message]:
    """Commands as sent: one at each change and, when the sender repeats itself, one each `resend` seconds between.

    Times are whole milliseconds; durations are stretched by up to 10 % so that drives do not share a rhythm.
    """
    sent: list[Message] = []
    t = 0.0
    for index, (v, omega, duration) in enumerate(segments):
        end = t + duration * random.uniform(1.0, 1.1)
        # nothing is sent to a robot that waits for the first command
        if index > 0:
            again = [t] if resend is None else list(np.arange(t, end - 0.05, resend))
            sent += [(round(float(time), 3), v, omega) for time in again]
        t = end
    return sent

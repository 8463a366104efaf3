"""Runs in the arena: whole swarms with random controllers, and pushes that make robots touch on purpose."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from tests.calibration.hidden.motion import Scene

Array = NDArray[np.float64]

ARENA = (0.0, 0.0, 1.70, 1.42)
"""Walls of the paper's arena: x0, y0, x1, y1 in m."""
DURATION = 20.0
"""Length of a run in the arena, s."""
APART = 0.17
"""Least distance of two robots' centres, and of a centre from a wall, at the start, m: more than two of the largest shields drawn."""


def _scattered(random: np.random.Generator, number: int) -> Array:
    places: list[Array] = []
    while len(places) < number:
        place = random.uniform([ARENA[0] + APART, ARENA[1] + APART], [ARENA[2] - APART, ARENA[3] - APART])
        if all(np.hypot(*(place - other)) > APART for other in places):
            places.append(place)
    return np.column_stack([np.array(places), random.uniform(0, 2 * np.pi, number)])


def swarms(random: np.random.Generator, runs: int, robots: int, factors: Array) -> Scene:
    """Whole swarms: in each run all robots run one random controller, drawn as the authors' simulator draws its genes.

    Args:
        random: Source of places and controllers.
        runs: Number of runs B.
        robots: Robots N in each.
        factors: The robots' gains, (N, 2).

    Returns:
        The scene.
    """
    sign = random.choice([-1.0, 1.0], (runs, 4))
    size = random.uniform([0.05, 0.4, 0.05, 0.4], [0.09, 1.6, 0.09, 1.6], (runs, 4))
    start = np.stack([_scattered(random, robots) for _ in range(runs)])
    return Scene(start, DURATION, np.broadcast_to(factors, (runs, robots, 2)), controllers=sign * size, arena=ARENA)


def pushes(random: np.random.Generator, runs: int, factors: Array) -> Scene:
    """Four robots: one drives into another, which stands or drives, off centre; two scrape walls at angles of 10 to 60 degrees.

    Each is tried twice in a run: forward into contact, back, a small turn, forward again.

    Args:
        random: Source of places, angles and speeds.
        runs: Number of runs B.
        factors: The robots' gains, (4, 2).

    Returns:
        The scene.
    """
    start = np.zeros((runs, 4, 3))
    told: list[tuple[int, int, float, float, float]] = []
    for run in range(runs):
        along = random.uniform(0, 2 * np.pi)
        ahead, aside = np.array([np.cos(along), np.sin(along)]), np.array([-np.sin(along), np.cos(along)])
        pushed = np.array([0.85, 0.71]) + random.uniform(-0.1, 0.1, 2)
        pusher = pushed - 0.2 * ahead + random.uniform(-0.08, 0.08) * aside
        start[run, 0] = [*pusher, along]
        start[run, 1] = [*pushed, random.uniform(0, 2 * np.pi)]
        for robot, (wall, y) in ((2, (ARENA[0], 0.3)), (3, (ARENA[2], 1.12))):
            angle = np.radians(random.uniform(10, 60)) * random.choice([-1, 1])
            inward = 1.0 if wall == ARENA[0] else -1.0
            start[run, robot] = [wall + inward * 0.14, y + random.uniform(-0.1, 0.1), (np.pi if inward > 0 else 0.0) + angle]
        for robot in range(4):
            if robot == 1 and random.random() < 0.5:
                continue
            v = random.uniform(0.05, 0.09)
            turn = random.choice([-1, 1]) * random.uniform(0.2, 0.5)
            stages = [(1.0, v, 0.0), (8.0, 0.0, 0.0), (9.0, -v, 0.0), (11.5, 0.0, turn), (12.5, v, 0.0), (19.0, 0.0, 0.0)]
            shift = random.uniform(0, 0.3)
            told += [(run, robot, round(t + shift, 3), speed, omega) for t, speed, omega in stages]
    return Scene(start, DURATION, np.broadcast_to(factors, (runs, 4, 2)), messages=told, arena=ARENA)

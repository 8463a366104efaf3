"""Runs in the arena: whole swarms with random controllers, and pushes that make robots touch on purpose."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from docs.studies.calibration.generator.motion import Scene

Array = NDArray[np.float64]

ARENA = (0.0, 0.0, 1.70, 1.42)
"""Walls of the paper's arena: x0, y0, x1, y1 in m."""
DURATION = 20.0
"""Length of a swarm's run, s."""
PUSH_DURATION = 30.0
"""Length of a run of pushes, s."""
PUSHERS = 6
"""Robots in a run of pushes."""
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
    """Six robots: two pairs of a pusher and a pushed, and two that scrape walls.

    A pusher drives off centre into the other, which stands, turns in place or drives, backs off and comes again. A scraper meets its wall
    at 10 to 45 degrees, drives on until friction has turned its nose in, turns along the wall while it still pushes, and so on.
    Contacts that graze or turn are what tells a high coefficient from a higher one: a head-on push sticks with either. By Coulomb's law
    a uniform disc at rest against the other slides only where the tangent of the angle off the normal exceeds three coefficients.

    Args:
        random: Source of places, angles and speeds.
        runs: Number of runs B.
        factors: The robots' gains, (PUSHERS, 2).

    Returns:
        The scene.
    """
    start = np.zeros((runs, PUSHERS, 3))
    told: list[tuple[int, int, float, float, float]] = []
    for run in range(runs):
        for pusher, x in ((0, 0.5), (2, 1.2)):
            along = random.uniform(0, 2 * np.pi)
            ahead, aside = np.array([np.cos(along), np.sin(along)]), np.array([-np.sin(along), np.cos(along)])
            pushed = np.array([x, 0.71]) + random.uniform(-0.03, 0.03, 2)
            start[run, pusher] = [*(pushed - 0.2 * ahead + random.choice([-1, 1]) * random.uniform(0.0, 0.1) * aside), along]
            start[run, pusher + 1] = [*pushed, random.uniform(0, 2 * np.pi)]
            told += _meetings(random, run, pusher)
        for robot, wall, y, normal in ((4, ARENA[0], 0.25, np.pi), (5, ARENA[2], 1.17, 0.0)):
            angle = np.radians(90 - random.uniform(10, 45)) * random.choice([-1, 1])
            start[run, robot] = [wall - 0.1 * np.cos(normal), y + random.uniform(-0.05, 0.05), normal + angle]
            told += _scrapes(random, run, robot)
    return Scene(start, PUSH_DURATION, np.broadcast_to(factors, (runs, PUSHERS, 2)), messages=told, arena=ARENA)


def _meetings(random: np.random.Generator, run: int, pusher: int) -> list[tuple[int, int, float, float, float]]:
    told: list[tuple[int, int, float, float, float]] = []
    for begin in np.arange(1.0, PUSH_DURATION - 6.0, 5.5):
        t, v = begin + random.uniform(0, 0.2), random.uniform(0.05, 0.09)
        told += [(run, pusher, t, v, 0.0), (run, pusher, t + 3.5, -v, 0.0), (run, pusher, t + 4.7, 0.0, 0.0)]
        omega = random.uniform(0.8, 2.4) * random.choice([-1, 1])
        still, spin, drive = (0.0, 0.0), (0.0, omega), (random.uniform(0.03, 0.06) * random.choice([-1, 1]), omega / 2)
        told += [(run, pusher + 1, t + 0.5, *(still, spin, spin, drive)[random.integers(4)]), (run, pusher + 1, t + 4.0, 0.0, 0.0)]
    return [(run, robot, round(float(t), 3), v, omega) for run, robot, t, v, omega in told]


def _scrapes(random: np.random.Generator, run: int, robot: int) -> list[tuple[int, int, float, float, float]]:
    told: list[tuple[int, int, float, float, float]] = []
    t, sign = 1.0 + random.uniform(0, 0.2), random.choice([-1, 1])
    while t < PUSH_DURATION - 5.5:
        v, omega = random.uniform(0.04, 0.09), random.uniform(0.8, 2.4)
        turn = random.uniform(0.8, 1.3) / omega
        told += [(run, robot, t, v, 0.0), (run, robot, t + 3.0, v, sign * omega)]
        t, sign = t + 3.0 + turn, -sign
    told.append((run, robot, t, 0.0, 0.0))
    return [(run, robot, round(float(t), 3), v, omega) for run, robot, t, v, omega in told]

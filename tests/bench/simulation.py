"""Speed of the simulation on one core, as a table: ``make bench``.

Each figure is a median over repetitions of one process; the plain pymunk loop beside them is measured in the same run, so that
ratios hold on any machine.
"""

from __future__ import annotations

import math
import statistics
import time
from collections.abc import Callable

import gymnasium as gym
import numpy as np
import pymunk

from swarm_envs import Simulation, load_world, rollouts
from swarm_envs.rendering import videos

BEHAVIOURS = {
    "spread out": [0.05, 1.6, 0.05, 1.6],
    "clustered": [-0.09, -1.2, 0.0, -1.6],
    "against walls": [0.09, 0.0, 0.09, 0.0],
}
"""A controller for each: robots that turn in place of their own, gather, or press against walls."""
STEPS = 600
REPETITIONS = 5


def rate(work: Callable[[], int]) -> float:
    """Median of units per second of CPU time over repetitions; ``work`` returns its units."""
    work()
    rates = []
    for _ in range(REPETITIONS):
        begin = time.process_time()
        units = work()
        rates.append(units / (time.process_time() - begin))
    return statistics.median(rates)


def rollout_rate(engine: str, controller: list[float], worlds: int) -> float:
    """World-steps per second of ``rollouts`` on one thread."""

    def work() -> int:
        rollouts("hero_plus", [controller] * worlds, engine=engine, threads=1, record_every=100)
        return worlds * STEPS

    return rate(work)


def plain_loop_rate(controller: list[float]) -> float:
    """World-steps per second of the loop that one writes first: Python, a force towards the wish, five substeps, ideal sensing."""
    world = load_world("hero_plus")

    def work(steps: int = 200) -> int:
        simulation = Simulation(world, 1)
        simulation.reset(0)
        space = pymunk.Space()
        space.collision_slop = 2e-4
        (width, height), bodies = world.size, []
        for a, b in [((0, 0), (width, 0)), ((width, 0), (width, height)), ((width, height), (0, height)), ((0, height), (0, 0))]:
            wall = pymunk.Segment(space.static_body, a, b, 0.0)
            wall.friction = 0.7
            space.add(wall)
        for x, y, heading in simulation.poses[0]:
            body = pymunk.Body(0.14, 0.5 * 0.14 * 0.06**2)
            body.position, body.angle = (float(x), float(y)), float(heading)
            shape = pymunk.Circle(body, 0.06)
            shape.friction = 0.55
            space.add(body, shape)
            bodies.append(body)
        for _ in range(steps):
            places = [(*body.position, body.angle) for body in bodies]
            for i, body in enumerate(bodies):
                v, omega = controller[2:] if sees(places, i) else controller[:2]
                body.velocity, body.angular_velocity = (v * math.cos(body.angle), v * math.sin(body.angle)), omega
            for _ in range(5):
                space.step(0.02)
        return steps

    return rate(work)


def sees(places: list[tuple[float, float, float]], i: int) -> bool:
    """Whether robot ``i`` has another in its sector."""
    x, y, heading = places[i]
    for j, (ox, oy, _) in enumerate(places):
        dx, dy = ox - x, oy - y
        along, across = dx * math.cos(heading) + dy * math.sin(heading), abs(dy * math.cos(heading) - dx * math.sin(heading))
        if j != i and along > 0 and math.hypot(dx, dy) <= 1.0 and across * math.cos(0.12) - along * math.sin(0.12) <= 0.04:
            return True
    return False


def step_rate(engine: str) -> float:
    """Steps per second of ``gym.make("HeRo/Swarm-v0")``."""
    env = gym.make("HeRo/Swarm-v0", engine=engine)
    action = np.tile(np.array([0.06, 0.8], np.float32), (8, 1))

    def work() -> int:
        env.reset(seed=0)
        for _ in range(STEPS):
            env.step(action)
        return STEPS

    return rate(work)


def video_rate() -> float:
    """Videos (3, 64, 64) per second on one thread."""
    runs = rollouts("hero_plus", np.random.default_rng(0).uniform(-1, 1, (200, 4)) * [0.09, 1.6, 0.09, 1.6])

    def work() -> int:
        for _ in range(5):
            videos(runs, threads=1)
        return 5 * len(runs)

    return rate(work)


def main() -> None:
    """Print the table."""
    print(f"{'what, on one core':44} {'per second of CPU':>18}")
    for name, controller in BEHAVIOURS.items():
        print(f"{'plain pymunk loop, ' + name + ', world-steps':44} {plain_loop_rate(controller):18,.0f}")
        for engine, worlds in (("chipmunk", 32), ("disc", 64)):
            print(f"{f'rollouts, {engine}, {name}, world-steps':44} {rollout_rate(engine, controller, worlds):18,.0f}", flush=True)
    for engine in ("chipmunk", "disc"):
        print(f"{f'gym.make(...).step, {engine}':44} {step_rate(engine):18,.0f}", flush=True)
    print(f"{'greyscale videos':44} {video_rate():18,.0f}")


if __name__ == "__main__":
    main()

"""Speed of the simulation on one core, as a table: ``make bench``.

Each figure is a median over repetitions of one process; the plain pymunk loop beside them is measured in the same run, so that
ratios hold on any machine.
"""

from __future__ import annotations

import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable

import gymnasium as gym
import numpy as np
import pymunk

from swarm_envs import Simulation, load_world, rollouts
from swarm_envs.rendering import videos
from swarm_envs.worlds import WorldSpec

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
    """World-steps per second of ``rollouts`` on one thread, for a world that is read already."""
    world = load_world("hero_plus")

    def work() -> int:
        rollouts(world, [controller] * worlds, engine=engine, threads=1, record_every=100)
        return worlds * STEPS

    return rate(work)


def plain_loop_rate(controller: list[float]) -> float:
    """World-steps per second of the loop that one writes first: a force towards the desired velocity in Python, five substeps."""
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


def vector_rate(copies: int = 256) -> float:
    """World-steps per second of ``gym.make_vec("HeRo/Swarm-v0")``, native."""
    env = gym.make_vec("HeRo/Swarm-v0", num_envs=copies, vectorization_mode="vector_entry_point")
    action = np.tile(np.array([0.05, 1.6], np.float32), (copies, 8, 1))

    def work() -> int:
        env.reset(seed=0)
        for _ in range(100):
            env.step(action)
        return 100 * copies

    return rate(work)


def thread_gain() -> float:
    """Wall-clock speed of two threads over that of one, the best of several each: other processes only ever slow one down."""
    world, controllers = load_world("hero_plus"), [BEHAVIOURS["clustered"]] * 512
    seconds: dict[int, list[float]] = {1: [], 2: []}
    for _ in range(REPETITIONS):
        for threads, taken in seconds.items():
            begin = time.perf_counter()
            rollouts(world, controllers, engine="disc", threads=threads, record_every=100)
            taken.append(time.perf_counter() - begin)
    return min(seconds[1]) / min(seconds[2])


def cost_of_many(robots: int = 1000) -> float:
    """CPU time of a robot's tick among ``robots`` in an arena as much larger, over that among eight; robots wander and meet."""
    rates = []
    for count in (8, robots):
        world = load_world("hero_plus").with_robots(count, scale_arena=True)
        worlds = 2048 // count

        def work(world: WorldSpec = world, worlds: int = worlds, count: int = count) -> int:
            rollouts(world, [[0.09, 0.5, 0.05, -1.6]] * worlds, engine="disc", threads=1, steps=STEPS, record_every=100)
            return worlds * count * STEPS

        rates.append(rate(work))
    return rates[0] / rates[1]


def first_use_seconds() -> float:
    """CPU seconds of the first rollout after an installation, in a process with an empty cache of compiled code."""
    program = "import time, swarm_envs; swarm_envs.rollouts('hero_plus', [[0.05, 0, 0, 0]], steps=1); print(time.process_time())"
    with tempfile.TemporaryDirectory() as folder:
        result = subprocess.run(
            [sys.executable, "-c", program], env=os.environ | {"NUMBA_CACHE_DIR": folder}, capture_output=True, text=True, check=True
        )
    return float(result.stdout)


def video_rate() -> float:
    """Videos (3, 64, 64) per second on one thread."""
    runs = rollouts("hero_plus", np.random.default_rng(0).uniform(-1, 1, (200, 4)) * [0.09, 1.6, 0.09, 1.6])

    def work() -> int:
        for _ in range(5):
            videos(runs, threads=1)
        return 5 * len(runs)

    return rate(work)


TARGETS = {"chipmunk": 70_000, "disc": 900_000}
"""World-steps per second asked of the median over behaviours."""


def line(what: str, value: float, target: str = "", decimals: int = 0) -> None:
    """Print a line of the table."""
    print(f"{what:48} {value:14,.{decimals}f}  {target}".rstrip(), flush=True)


def main() -> None:
    """Print the table."""
    print(f"{'what, on one core':48} {'per CPU second':>14}  asked for")
    rates: dict[str, list[float]] = {"plain pymunk loop": [], "chipmunk": [], "disc": []}
    for name, controller in BEHAVIOURS.items():
        rates["plain pymunk loop"].append(plain_loop_rate(controller))
        line(f"plain pymunk loop, {name}, world-steps", rates["plain pymunk loop"][-1])
        for engine, worlds in (("chipmunk", 64), ("disc", 512)):
            rates[engine].append(rollout_rate(engine, controller, worlds))
            line(f"rollouts, {engine}, {name}, world-steps", rates[engine][-1])
    for engine, each in rates.items():
        target = f"{TARGETS[engine]:,}" if engine in TARGETS else ""
        line(f"{engine}, median over behaviours, world-steps", statistics.median(each), target)
    line("vector environment, 256 worlds, world-steps", vector_rate(), "400,000")
    for engine in ("chipmunk", "disc"):
        line(f"gym.make(...).step, {engine}", step_rate(engine), "12,000")
    line("greyscale videos", video_rate())
    line("two threads over one, wall clock, ratio", thread_gain(), "at least 1.8", 2)
    line("a robot's tick among 1,000 over 8, ratio", cost_of_many(), "at most 3", 2)
    line("first use, compiling, CPU s", first_use_seconds(), "at most 20", 1)


if __name__ == "__main__":
    main()

"""Many worlds at once, each with its own controllers."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import numpy.typing as npt

from swarm_envs.cores import available_cores
from swarm_envs.simulation.parameters import FloatArray
from swarm_envs.simulation.simulation import Simulation, check_engine
from swarm_envs.simulation.trajectories import Trajectories
from swarm_envs.worlds import WorldError, WorldSpec, load_world

CHUNK = 64
"""Worlds that a thread runs before it takes the next; no result depends on it."""


def rollouts(
    world: str | Path | WorldSpec,
    controllers: npt.ArrayLike,
    *,
    seed: int = 0,
    first: int = 0,
    steps: int = 600,
    robots: int | None = None,
    initial_poses: npt.ArrayLike | None = None,
    record_every: int = 1,
    threads: int | None = None,
    engine: str | None = None,
) -> Trajectories:
    """Run one world per controller and return what was recorded.

    Args:
        world: A world's name, file or spec.
        controllers: (W, 4) one controller [v0, omega0, v1, omega1] for all robots of a world, or (W, R, 4) one for each, in m/s and
            rad/s: (v0, omega0) without a detection, (v1, omega1) with one (paper, Kinematics and Controllers). With K readings per
            robot, 2 * 2^K numbers: one pair for each pattern of readings, the first sensor counting 1. In a world with a broadcast a
            robot sends whether its sensors report something, and whether it hears another is its last reading.
        seed: World i draws its start and every effect from (seed, first + i).
        first: Number of the first world; with it, world ``first`` of an earlier call is repeated alone, to the last bit.
        steps: Ticks to run.
        robots: Number of robots instead of the world's own.
        initial_poses: (W, R, 3) x, y in m and heading in rad instead of drawn starts.
        record_every: Ticks from one recorded frame to the next; memory grows with the frames.
        threads: Threads to run on; all cores by default. The result does not depend on it.
        engine: ``chipmunk`` or ``disc``; by default ``disc`` where it can represent the world.

    Returns:
        Frames 0, record_every, ... of every world, at most ``steps``.

    Raises:
        WorldError: For an unknown world or engine, controllers of another shape, not finite or outside the limits, or poses that do
            not fit.
    """
    spec = load_world(world, num_robots=robots)
    array = check_controllers(spec, controllers)
    chosen = check_engine(spec, engine or ("chipmunk" if spec.objects else "disc"))
    if steps < 0 or record_every < 1 or first < 0:
        raise WorldError(f"rollouts: steps is {steps}, record_every {record_every} and first {first}, expected at least 0, 1 and 0")
    count, frames = len(array), steps // record_every + 1
    poses = np.empty((count, frames, spec.num_robots, 3))
    detections = np.zeros((count, frames, spec.num_robots, spec.num_readings), np.uint8)
    commands = np.empty((count, frames, spec.num_robots, 2))
    objects = np.empty((count, frames, len(spec.objects), 3)) if spec.objects else None
    starts = None if initial_poses is None else np.asarray(initial_poses, dtype=np.float64)
    if starts is not None and starts.shape != (count, spec.num_robots, 3):
        raise WorldError(f"initial_poses: shape is {starts.shape}, expected {(count, spec.num_robots, 3)} (worlds, robots, x y heading)")

    def run(begin: int) -> None:
        part = slice(begin, min(begin + CHUNK, count))
        simulation = Simulation(spec, part.stop - part.start, chosen)
        simulation.reset(seed, first=first + begin, initial_poses=None if starts is None else starts[part])
        if objects is None:
            simulation.run(array[part], steps, record_every, poses[part], detections[part], commands[part])
            return
        objects[part, 0] = simulation.objects
        simulation.run(array[part], 0, 1, poses[part, :1], detections[part, :1], commands[part, :1])
        for k in range(frames - 1):  # compiled code does not write objects down: from one recorded frame to the next
            two = (part, slice(k, k + 2))
            simulation.run(array[part], record_every, record_every, poses[two], detections[two], commands[two])
            objects[part, k + 1] = simulation.objects

    workers = threads or available_cores()
    with ThreadPoolExecutor(max_workers=workers) as pool:
        for _ in pool.map(run, range(0, count, CHUNK)):
            pass
    time = np.arange(frames, dtype=np.float64) * (record_every * spec.tick)
    return Trajectories(spec, chosen, time, poses, detections[..., 0] if spec.num_readings == 1 else detections, commands, objects)


def check_controllers(world: WorldSpec, controllers: npt.ArrayLike) -> FloatArray:
    """Return controllers as (W, R, numbers).

    Raises:
        WorldError: When the shape is another, or a number is not finite or outside the world's limits.
    """
    array = np.asarray(controllers, dtype=np.float64)
    allowed = [2 * 2**inputs for inputs in range(1, world.num_readings + 1)]
    if array.ndim not in (2, 3) or array.shape[-1] not in allowed or (array.ndim == 3 and array.shape[1] != world.num_robots):
        numbers = " or ".join(str(n) for n in allowed)
        raise WorldError(
            f"controllers: shape is {array.shape}, expected (worlds, {numbers}) or (worlds, {world.num_robots}, {numbers}): "
            "[v0, omega0, v1, omega1]"
        )
    if not np.all(np.isfinite(array)):
        raise WorldError("controllers: hold a value that is not finite; expected speeds in m/s and rad/s")
    for offset, limit, unit in ((0, world.limits.linear_speed, "m/s"), (1, world.limits.angular_speed, "rad/s")):
        largest = float(np.abs(array[..., offset::2]).max(initial=0.0))
        if largest > limit * (1 + 1e-9):
            name = "v" if offset == 0 else "omega"
            raise WorldError(
                f"controllers: {name} of {largest:g} {unit} is outside the limits of {world.name!r}, expected at most {limit:g} {unit}"
            )
    if array.ndim == 2:
        array = np.repeat(array[:, None, :], world.num_robots, axis=1)
    return np.ascontiguousarray(array)

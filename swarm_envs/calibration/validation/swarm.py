"""How what a swarm does moves when its world is calibrated: metrics, labels and detections of whole-swarm runs, before and after.

``average_speed``, ``angular_momentum``, ``radial_variance``, ``scatter``, ``group_rotation`` (see :mod:`swarm_envs.metrics`) and ``label``
(see :mod:`swarm_envs.behaviours`) compare the measured run with its commands replayed from the first poses, all robots together inside
the log's outline. ``closed_loop.`` before the name: the controllers run instead, on the simulated readings; they are read from the log,
where commands follow detections. ``detections`` is the share of readings that come out otherwise at the measured poses.

Errors are root mean squares over runs, of labels and detections the share that differs. The drive that a run is simulated with was
fitted without it; numbers of the sensor and of contact come from all runs.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from swarm_envs import behaviours, metrics
from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.drive.fitting import Model
from swarm_envs.calibration.drive.measured import Measured
from swarm_envs.calibration.drive.noise import HEADING, PLACE
from swarm_envs.calibration.drive.parameters import drive_parameters, with_drive
from swarm_envs.calibration.logs.log import Log
from swarm_envs.calibration.prediction.arena import TICK, arena_world, motion, replay
from swarm_envs.calibration.validation.gain import Gain, bootstrap
from swarm_envs.calibration.validation.swarm_detections import detections_gain
from swarm_envs.calibration.validation.swarm_runs import EVERY, SwarmRun, swarm_runs
from swarm_envs.simulation import rollouts
from swarm_envs.worlds import WorldError, WorldSpec

METRICS = {"average_speed": "m/s", "angular_momentum": "m/s", "radial_variance": "1", "scatter": "1", "group_rotation": "m/s"}
"""Names and units in the order of :func:`swarm_envs.metrics.hand_crafted`."""
COPIES = 8
"""Closed-loop runs of each world."""


@dataclass(frozen=True)
class Recorded:
    """What metrics need of a run, measured or simulated."""

    poses: FloatArray
    """(worlds, frames, robots, 3) m, m, rad."""
    time: FloatArray
    """(frames,) s."""
    world: WorldSpec


def swarm_gain(
    log: Log,
    data: Measured,
    after: Sequence[Model],
    world: WorldSpec,
    extended: WorldSpec,
    progress: Callable[[str], None] = lambda text: None,
) -> list[Gain]:
    """Return the gain per metric of whole-swarm runs; nothing where a log has none.

    Args:
        log: The log.
        data: The same, as its drives were fitted.
        after: For each group of the data the model that was fitted without it.
        world: The world as it was.
        extended: The world with the named effects.
        progress: Called with a line at each step.
    """
    runs = swarm_runs(log, data, after)
    if not runs:
        return []
    progress(f"replaying {len(runs)} runs of whole swarms")
    found = detections_gain(runs, world, extended)
    if log.outline is not None:
        found += _replayed(log, runs, world, extended)
        found += _closed_loop(log, runs, world, extended)
    return found


# simulations


def _replay(log: Log, run: SwarmRun, world: WorldSpec, parameters: FloatArray, gains: dict[str, FloatArray] | None) -> FloatArray:
    """Return the frames (1, F, R, 3) of a run whose commands are replayed from its first poses."""
    ticks = EVERY * (len(run.frames) - 1)
    moved = motion(parameters, run.tracks, run.begin, ticks, gains)
    spec = arena_world(world, log.outline, len(run.tracks))
    return replay(spec, moved, np.zeros(1, np.int64), run.frames[:1], ticks)[::EVERY, 0][None]


def _controlled(log: Log, run: SwarmRun, world: WorldSpec, seed: int) -> tuple[FloatArray, float] | None:
    """Return frames (COPIES, F, R, 3) of a run's controller in a world and the share of readings that detect; None if it cannot start."""
    assert run.controller is not None
    assert log.outline is not None
    fastest = np.abs(run.controller).reshape(2, 2).max(axis=0)
    robots = []
    for index in range(len(run.tracks)):
        robot = world.robots[index % world.num_robots]
        drive = dataclasses.replace(
            robot.drive,
            max_linear_speed=max(robot.drive.max_linear_speed, float(fastest[0])),
            max_angular_speed=max(robot.drive.max_angular_speed, float(fastest[1])),
        )
        robots.append(dataclasses.replace(robot, drive=drive))
    limits = dataclasses.replace(
        world.limits,
        linear_speed=max(world.limits.linear_speed, float(fastest[0])),
        angular_speed=max(world.limits.angular_speed, float(fastest[1])),
    )
    arena = dataclasses.replace(world.arena, outline=log.outline, obstacles=())
    spec = world.replace(arena=arena, objects=(), broadcast=None, limits=limits, robots=tuple(robots), tick=EVERY * TICK)
    try:
        played = rollouts(
            spec, np.tile(run.controller, (COPIES, 1)) if spec.num_readings == 1 else np.empty((0, 0)), seed=seed,
            steps=len(run.frames) - 1, initial_poses=np.repeat(run.frames[:1], COPIES, axis=0), engine="disc",
        )  # fmt: skip
    except WorldError:
        # bodies that overlap where the tracker saw them, or a robot with several sensors
        return None
    return played.poses, float(played.detections[:, 1:].mean())


# comparisons


def _measure(frames: FloatArray, time: FloatArray, world: WorldSpec) -> tuple[FloatArray, list[str]]:
    """Return the metrics (W, 5) and labels of W runs."""
    recorded = Recorded(frames, time, world)
    return metrics.hand_crafted(recorded), behaviours.label(recorded)


def _replayed(log: Log, runs: Sequence[SwarmRun], world: WorldSpec, extended: WorldSpec) -> list[Gain]:
    generator = np.random.default_rng(0)
    rows = []
    for run in runs:
        judged = arena_world(extended, log.outline, len(run.tracks)).replace(tick=EVERY * TICK)
        noise = generator.normal(size=run.frames.shape) * run.model.noise[[PLACE, PLACE, HEADING]]
        frames = np.concatenate([
            run.frames[None], _replay(log, run, world, drive_parameters(world), None),
            _replay(log, run, extended, run.model.parameters, run.gains), (run.frames + noise)[None],
        ])  # fmt: skip
        numbers, labels = _measure(frames, run.time, judged)
        rows.append([np.append(numbers[k] - numbers[0], labels[k] != labels[0]) for k in (1, 2, 3)])
    return _gains("", np.array(rows))


def _closed_loop(log: Log, runs: Sequence[SwarmRun], world: WorldSpec, extended: WorldSpec) -> list[Gain]:
    rows, rates = [], []
    for seed, run in enumerate(runs):
        if run.controller is None:
            continue
        before, after = (_controlled(log, run, spec, seed) for spec in (world, with_drive(extended, run.model.parameters)))
        if before is None or after is None:
            continue
        judged = arena_world(extended, log.outline, len(run.tracks)).replace(tick=EVERY * TICK)
        true, label = _measure(run.frames[None], run.time, judged)
        errors = []
        for frames, _ in (before, after):
            numbers, labels = _measure(frames, run.time, judged)
            errors.append(np.append(numbers.mean(axis=0) - true[0], np.mean([name != label[0] for name in labels])))
        chance = numbers.std(axis=0, ddof=1) * np.sqrt(1 + 1 / COPIES)
        shares = [labels.count(name) / COPIES for name in set(labels)]
        rows.append([*errors, np.append(chance, 1.0 - sum(share**2 for share in shares))])
        seen = np.mean([track.detections.mean() for track in run.tracks])
        rates.append([before[1] - seen, after[1] - seen])
    if not rows:
        return []
    squares = np.column_stack([np.array(rates) ** 2, np.ones(len(rates))])
    was, now = np.sqrt(squares[:, :2].mean(axis=0))
    rate = Gain("closed_loop.detection_rate", None, "1", float(was), float(now), bootstrap(squares), None)
    return [*_gains("closed_loop.", np.array(rows)), rate]


def _gains(prefix: str, rows: FloatArray) -> list[Gain]:
    """Return the gains from errors (runs, 3, 6): before, after and by chance alone; of the five metrics and of the label."""
    found = []
    for k, (name, unit) in enumerate((*METRICS.items(), ("label", "1"))):
        # a label is right or wrong: its errors are averaged, not squared
        power = 1 if name == "label" else 2
        sums = np.abs(rows[:, :, k]) ** power
        was, now, floor = (float(value) ** (1 / power) for value in sums.mean(axis=0))
        interval = bootstrap(np.column_stack([sums[:, :2], np.ones(len(sums))]), root=power == 2)
        found.append(Gain(f"{prefix}{name}", None, unit, was, now, interval, floor))
    return found

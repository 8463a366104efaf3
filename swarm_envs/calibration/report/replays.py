"""Runs to play beside their simulations: what was measured, what the world predicted, what the calibrated world predicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.drive.fitting import Model
from swarm_envs.calibration.drive.measured import Measured, run_of
from swarm_envs.calibration.drive.motion import free_run
from swarm_envs.calibration.drive.parameters import drive_parameters
from swarm_envs.calibration.logs.log import Log, Track
from swarm_envs.calibration.prediction.arena import TICK, arena_world, at, motion, replay
from swarm_envs.worlds import WorldSpec

STEP = 0.1
"""Time in s from one frame to the next."""
LONGEST = 60.0
"""Time in s of a run that is shown."""
MOST = 3
"""Runs that are shown."""


@dataclass(frozen=True)
class Replay:
    """A run of R robots in F frames, three times."""

    run: str
    measured: FloatArray
    """(F, R, 3) m, m, rad."""
    before: FloatArray
    """(F, R, 3) by the commands alone from the first poses, with the world as it was."""
    after: FloatArray
    """(F, R, 3) with the effects, fitted without the run."""
    missing: FloatArray
    """(F, R) 1 where the tracker saw no robot."""


def replays(log: Log, data: Measured, after: Sequence[Model], world: WorldSpec, extended: WorldSpec) -> list[Replay]:
    """Return the runs that show most: those with most turning and driving, each simulated from its first poses.

    Args:
        log: The log.
        data: The same, as it was fitted.
        after: For each group of the data the model that was fitted without it.
        world: The world as it was.
        extended: The world with the named effects.
    """
    models = {run_of(name): model for name, model in zip(data.runs, after, strict=True)}
    ranked = sorted({track.run for track in log.tracked}, key=lambda run: -_liveliness([t for t in log.tracked if t.run == run]))
    chosen = [run for run in log.runs if run in ranked[:MOST]]
    return [_replay(log, run, data, models[run], world, extended) for run in chosen]


def _liveliness(tracks: Sequence[Track]) -> float:
    """Return how much a run has to show: metres driven and radians turned, by all its robots."""
    total = 0.0
    for track in tracks:
        kept = track.poses[track.times - track.times[0] < LONGEST][::20]
        total += float(np.hypot(*np.diff(kept[:, :2], axis=0).T).sum() + 0.1 * np.abs(np.diff(kept[:, 2])).sum())
    return total


def _replay(log: Log, run: str, data: Measured, model: Model, world: WorldSpec, extended: WorldSpec) -> Replay:
    tracks = [track for track in log.tracked if track.run == run]
    begin = max(track.times[0] for track in tracks)
    end = min(begin + LONGEST, max(track.times[-1] for track in tracks))
    times = begin + STEP * np.arange(int((end - begin) / STEP) + 1)
    measured = np.stack([at(track, times) for track in tracks], axis=1)
    gap = np.stack([_gap(track, times) for track in tracks], axis=1)
    gains = dict(zip(data.robots, model.gains, strict=True))
    if log.outline is not None:
        every = round(STEP / TICK)
        ticks = every * (len(times) - 1)
        paths = [
            replay(
                arena_world(spec, log.outline, len(tracks)), motion(parameters, tracks, float(begin), ticks, own),
                np.zeros(1, np.int64), measured[:1], ticks,
            )[::every, 0]
            for spec, parameters, own in ((world, drive_parameters(world), None), (extended, model.parameters, gains))
        ]  # fmt: skip
    else:
        paths = [
            np.stack([_alone(parameters, track, times, own) for track in tracks], axis=1)
            for parameters, own in ((drive_parameters(world), None), (model.parameters, gains))
        ]
    return Replay(run, measured, paths[0], paths[1], gap)


def _alone(parameters: FloatArray, track: Track, times: FloatArray, gains: dict[str, FloatArray] | None) -> FloatArray:
    grid = Track(
        track.run, track.robot, times, at(track, times), track.command_times, track.commands, track.detection_times, track.detections
    )
    free = free_run(parameters, grid, None if gains is None else gains[track.robot])
    return free.from_pose(0, grid.poses[0], slice(None))


def _gap(track: Track, times: FloatArray) -> FloatArray:
    near = np.clip(np.searchsorted(track.times, times), 1, len(track.times) - 1)
    return np.asarray((track.times[near] - track.times[near - 1] > 1.0) | (times > track.times[-1]), float)

"""How well a world predicts a log: free-running windows that start at a measured pose and see nothing but the commands."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from swarm_envs.calibration.drive import drive_parameters, free_run
from swarm_envs.calibration.errors import LogError
from swarm_envs.calibration.log import FloatArray, Log, Track, read_log
from swarm_envs.worlds import WorldSpec, load_world

HORIZONS = (1.0, 5.0, 10.0)
"""Lengths of the windows in s."""
STRIDE = 0.5
"""Time in s from one window's start to the next one's."""
NEAR = 0.1
"""A window counts when a pose was measured within this time, s, of its end."""


@dataclass(frozen=True)
class WindowErrors:
    """Errors at the ends of a track's windows of one length."""

    starts: FloatArray
    """(W,) times of the starts in s."""
    position: FloatArray
    """(W,) distance between predicted and measured place in m."""
    heading: FloatArray
    """(W,) predicted minus measured heading in rad, in [-pi, pi)."""


def windows(times: FloatArray, horizon: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the indices of the poses that start and end each window of a track."""
    wanted = np.arange(times[0], times[-1] - horizon + 1e-9, STRIDE) if len(times) else np.empty(0)
    first = np.searchsorted(times, wanted - 1e-9)
    goal = times[np.minimum(first, len(times) - 1)] + horizon
    after = np.clip(np.searchsorted(times, goal), 1, len(times) - 1)
    last = np.where(np.abs(times[after] - goal) < np.abs(times[after - 1] - goal), after, after - 1)
    # where tracking was lost several wanted starts fall on one pose
    good = (np.abs(times[last] - goal) <= NEAR) & (last > first) & np.append(True, np.diff(first) > 0)[: len(first)]
    return first[good], last[good]


def window_errors(parameters: FloatArray, track: Track, horizon: float, gain: FloatArray | None = None) -> WindowErrors:
    """Return the errors of a drive's prediction of one track.

    Args:
        parameters: (16,) of the drive.
        track: The track.
        horizon: Length of the windows in s.
        gain: (2,) the robot's own factors on both gains.
    """
    first, last = windows(track.times, horizon)
    prediction = free_run(parameters, track, gain)
    turn = track.poses[first, 2] - prediction.marker_yaw - prediction.path[first, 2]
    gone = prediction.path[last, :2] - prediction.path[first, :2]
    c, s = np.cos(turn), np.sin(turn)
    moved = np.column_stack([c * gone[:, 0] - s * gone[:, 1], s * gone[:, 0] + c * gone[:, 1]])
    place = track.poses[first, :2] + moved + prediction.drift[last] - prediction.drift[first]
    turned = prediction.path[last, 2] - prediction.path[first, 2] - (track.poses[last, 2] - track.poses[first, 2])
    return WindowErrors(
        starts=track.times[first],
        position=np.hypot(*(place - track.poses[last, :2]).T),
        heading=(turned + math.pi) % (2 * math.pi) - math.pi,
    )


def predictor(
    log: Log, world: WorldSpec, parameters: FloatArray, gains: Mapping[str, FloatArray] | None = None, runs: Iterable[str] | None = None
) -> Callable[[Track, float], WindowErrors]:
    """Return a function that gives the errors of a drive's prediction of a track at a horizon in s.

    Args:
        log: The log; with an outline, prediction knows walls and the other robots.
        world: Whose bodies and contact meet them.
        parameters: (16,) of the drive.
        gains: (2,) by robot, its own factors on both gains.
        runs: Only tracks of these runs will be asked for; all by default.
    """
    if log.outline is None:
        return lambda track, horizon: window_errors(parameters, track, horizon, None if gains is None else gains.get(track.robot))
    from swarm_envs.calibration.enclosed import enclosed_errors

    known = enclosed_errors(log, world, parameters, gains, runs)
    nothing = WindowErrors(np.empty(0), np.empty(0), np.empty(0))
    return lambda track, horizon: known[horizon].get((track.run, track.robot), nothing)


def rms(values: FloatArray) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else math.nan


def evaluate(world: str | Path | WorldSpec, log: str | Path | Log) -> dict[str, dict[str, float]]:
    """Return how well a world predicts a log when nothing is fitted.

    Each window starts at a measured pose; the world's drive, its effects included, and the commands do the rest. Where the log gives
    the arena's outline, robots of a run are predicted together, and the walls and their bodies hold them up; elsewhere each drives
    alone on an open floor.

    Args:
        world: A world's name, YAML file or spec.
        log: A log or its folder.

    Returns:
        For each horizon (``"1.0"``, ``"5.0"``, ``"10.0"`` seconds) the rms at the window's end as ``position_m`` and
        ``heading_rad``, and the number of ``windows``. A horizon that no run reaches is left out.

    Raises:
        LogError: When the log cannot be read, or has nothing to predict.
        WorldError: When there is no such world.
    """
    spec = load_world(world)
    log = read_log(log) if isinstance(log, str | Path) else log
    tracks = tracked(log)
    predict = predictor(log, spec, drive_parameters(spec))
    result = {}
    for horizon in HORIZONS:
        errors = [predict(track, horizon) for track in tracks]
        position, heading = np.concatenate([e.position for e in errors]), np.concatenate([e.heading for e in errors])
        if len(position):
            result[f"{horizon:.1f}"] = {"position_m": rms(position), "heading_rad": rms(heading), "windows": len(position)}
    if not result:
        raise LogError(f"{log.name}: no run lasts {HORIZONS[0]} s with poses; nothing to predict")
    return result


def tracked(log: Log) -> tuple[Track, ...]:
    """Return the tracks that can be predicted.

    Raises:
        LogError: When there is none.
    """
    if not log.tracked:
        raise LogError(f"{log.name}: no robot has both poses and commands; nothing to predict")
    return log.tracked

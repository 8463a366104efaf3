"""First guesses: gains where commands are far from SI units, and the noise."""

from __future__ import annotations

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.drive.measured import Measured
from swarm_envs.calibration.drive.motion import free_run
from swarm_envs.calibration.logs.log import Log, Track, tracked

WINDOW = 1.0
"""Time in s over which measured motion is held against predicted motion."""
LIKELY = (0.05, 20.0)
"""Gains beyond these say that commands are not in SI units."""


def initial_gains(log: Log, base: FloatArray) -> tuple[float, float]:
    """Return the ratios of measured to predicted motion over one second, forward and turning; NaN where none was commanded.

    Args:
        log: The log.
        base: (P,) the drive's parameters.
    """
    driven = [_ahead_and_turned(track, base) for track in tracked(log)]
    forward, turning = (_ratio(np.concatenate(pairs)) for pairs in zip(*driven, strict=True))
    return forward, turning


def in_other_units(log: Log, gains: tuple[float, float]) -> bool:
    """Whether commands are so far from SI units that gains have to be fitted before anything else."""
    return log.driver_units or any(not LIKELY[0] < gain < LIKELY[1] for gain in gains if np.isfinite(gain))


def _ahead_and_turned(track: Track, base: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return predicted and measured motion (W, 2) over some windows, forward in m, and turns in rad."""
    path = free_run(base, track).path
    last = np.searchsorted(track.times, track.times + WINDOW)
    first = np.flatnonzero(last < len(track.times))[::10]
    last = last[first]
    ahead = [_ahead(poses[first], poses[last]) for poses in (path, track.poses)]
    return np.column_stack(ahead), np.column_stack([poses[last, 2] - poses[first, 2] for poses in (path, track.poses)])


def _ahead(begin: FloatArray, end: FloatArray) -> FloatArray:
    """Return how far (W,) windows lead along their mean heading, in m."""
    gone, heading = end[:, :2] - begin[:, :2], 0.5 * (begin[:, 2] + end[:, 2])
    return np.asarray(gone[:, 0] * np.cos(heading) + gone[:, 1] * np.sin(heading))


def _ratio(pairs: FloatArray) -> float:
    """Return the median ratio of measured to predicted motion where that is large."""
    asked, done = pairs.T
    large = np.abs(asked) > 0.5 * np.abs(asked).max(initial=0.0)
    return float(np.median(done[large] / asked[large])) if large.sum() > 3 and np.abs(asked).max() > 1e-6 else float("nan")


def initial_noise(data: Measured) -> FloatArray:
    """Return a first guess of the noise (5,) from third differences, which smooth motion hardly has."""
    thirds = np.diff(data.poses, 3, axis=0)
    sd = np.maximum(np.median(np.abs(thirds), axis=0) / 0.6745 / np.sqrt(20.0), (1e-5, 1e-5, 1e-4))
    return np.array([max(sd[0], sd[1]), sd[2], 3e-3, 2e-3, 3e-2])

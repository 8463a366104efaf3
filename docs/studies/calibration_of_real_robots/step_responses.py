"""Starts, stops and turns of a log: when the robot answers a command, and how fast it then is."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from swarm_envs.calibration import Log, Track

Array = npt.NDArray[np.float64]


class Step(NamedTuple):
    """A change of the commanded forward speed between rest and motion, straight ahead, held for 1.5 s at least."""

    track: Track
    at: float
    """s"""
    speed: float
    """m/s or the driver's, that is started or stopped."""
    starts: bool


def steps(log: Log) -> Iterator[Step]:
    """Yield a log's starts and stops."""
    for track in log.tracked:
        times = np.append(track.command_times, track.times[-1])
        commands = np.vstack([np.zeros(2), track.commands])
        for k, (old, new) in enumerate(pairwise(commands)):
            if (old[0] == 0) != (new[0] == 0) and not old[1] and not new[1] and times[k + 1] - times[k] >= 1.5:
                yield Step(track, float(times[k]), float(new[0] or old[0]), bool(new[0] != 0))


def response(step: Step, path: Array, after: Array) -> Array:
    """Return the forward speed over the commanded one, in the middles of the intervals between ``after`` (K + 1,) s after the command."""
    at = np.clip(step.at + after, step.track.times[0], step.track.times[-1])
    x, y, heading = (np.interp(at, step.track.times, path[:, k]) for k in range(3))
    ahead = heading[len(at) // 2]
    along = np.diff(x) * np.cos(ahead) + np.diff(y) * np.sin(ahead)
    return np.asarray(along / np.diff(after) / step.speed)


def turns(log: Log) -> Iterator[Step]:
    """Yield a log's changes of the commanded turn rate, after 0.5 s and before 0.25 s of steady commands."""
    for track in log.tracked:
        times, rates = np.append(track.command_times, track.times[-1]), np.append(0.0, track.commands[:, 1])
        for k, (old, new) in enumerate(pairwise(rates)):
            before = times[k] - (times[k - 1] if k else track.times[0])
            if old != new and before >= 0.5 and times[k + 1] - times[k] >= 0.25:
                yield Step(track, float(times[k]), float(new - old), bool(new != 0))


def onset(step: Step, turning: bool = False) -> float:
    """Return the time in s from a command to the bend in the robot's way or heading, by least squares of two lines over -0.5 to 0.2 s.

    NaN where two lines do not fit: the tracker flipped.
    """
    inside = (step.track.times > step.at - 0.5) & (step.track.times < step.at + 0.2)
    t, poses = step.track.times[inside] - step.at, step.track.poses[inside]
    ahead = np.median(poses[:, 2])
    way = poses[:, 2] if turning else poses[:, :2] @ np.array([np.cos(ahead), np.sin(ahead)])

    def misfit(bend: float) -> float:
        lines = np.column_stack([np.ones_like(t), np.minimum(t, bend), np.maximum(t - bend, 0)])
        return float(np.mean((lines @ np.linalg.lstsq(lines, way, rcond=None)[0] - way) ** 2))

    candidates = np.arange(-0.05, 0.19, 0.002)
    misfits = [misfit(bend) for bend in candidates]
    return float(candidates[np.argmin(misfits)]) if np.sqrt(min(misfits)) < 0.05 else float("nan")

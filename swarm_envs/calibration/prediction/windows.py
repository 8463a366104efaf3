"""Free-running windows, which start at a measured pose and see nothing but the commands, and the errors at their ends."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.drive.motion import free_run
from swarm_envs.calibration.logs.log import Track

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
        parameters: (P,) of the drive.
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


def rms(values: FloatArray) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(np.square(values)))) if len(values) else math.nan

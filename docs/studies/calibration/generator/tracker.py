"""What the tracker and the operator's computer write down."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from docs.studies.calibration.generator.motion import STEP, Track
from docs.studies.calibration.generator.wheels import Effects

Array = NDArray[np.float64]

RATE = 60.0
"""Frames of the tracker in a second."""
JITTER = 0.0003
"""Standard deviation of the time between frames about its mean, s."""
DROPPED = 0.005
"""Share of frames in which the tracker loses the robot."""


@dataclass(frozen=True)
class Noise:
    """The tracker's noise, white.

    Attributes:
        position: Standard deviation along x and along y, m.
        heading: Standard deviation, rad.
    """

    position: float
    heading: float


def observe(track: Track, run: int, robot: int, effects: Effects, noise: Noise, random: np.random.Generator) -> Array:
    """The frames of one robot.

    clock_offset: a frame taken at t on the clock of commands and detections is stamped t + offset. marker_yaw: every measured heading
    is turned by yaw.

    Args:
        track: What truly happened.
        run: Index of the run in the track.
        robot: Index of the robot.
        effects: The hidden effects.
        noise: The tracker's noise.
        random: Its source.

    Returns:
        Rows t, x, y, theta: (T, 4), in s, m and rad, theta in (-pi, pi].
    """
    duration = (len(track.poses) - 1) * STEP
    stamps = np.cumsum(np.abs(1 / RATE + random.normal(0, JITTER, int(duration * RATE) - 1)))
    stamps = np.round(np.concatenate([[0.0], stamps[random.random(len(stamps)) >= DROPPED]]), 6)
    taken = stamps - effects.get("clock_offset", {}).get("offset", 0.0)
    inside = taken <= duration
    stamps, taken = stamps[inside], taken[inside]
    clock = np.arange(len(track.poses)) * STEP
    # before time zero the robot rests where it starts
    true = np.stack([np.interp(taken, clock, track.poses[:, run, robot, k]) for k in range(3)], axis=1)
    true[:, :2] += random.normal(0, noise.position, (len(taken), 2))
    true[:, 2] += random.normal(0, noise.heading, len(taken)) + effects.get("marker_yaw", {}).get("yaw", 0.0)
    true[:, 2] = np.pi - (np.pi - true[:, 2]) % (2 * np.pi)
    return np.column_stack([stamps, true])

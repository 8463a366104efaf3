"""What a robot's forward sensor reports."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from docs.studies.calibration.generator.wheels import Effects

Array = NDArray[np.float64]

HALF_ANGLE = 0.12
"""Half of the sensor's opening, rad (hero_plus world)."""
RANGE = 1.0
"""Reach to the other robot's centre, m (hero_plus world)."""
VISIBLE_RADIUS = 0.04
"""Radius of the body that the sensor sees, m (hero_plus world)."""


def in_view(poses: Array, effects: Effects) -> NDArray[np.bool_]:
    """Whether each robot has another in its sector: the other's centre in range, its disc meeting the sector.

    Args:
        poses: (..., N, 3).
        effects: detection_range, field_of_view and sensor_yaw act here.

    Returns:
        (..., N).
    """
    reach = effects.get("detection_range", {}).get("range", RANGE)
    half = effects.get("field_of_view", {}).get("half_angle", HALF_ANGLE)
    yaw = effects.get("sensor_yaw", {}).get("yaw", 0.0)
    dx = poses[..., None, :, 0] - poses[..., :, None, 0]
    dy = poses[..., None, :, 1] - poses[..., :, None, 1]
    distance = np.hypot(dx, dy)
    off = np.arctan2(dy, dx) - poses[..., :, None, 2] - yaw
    off = np.abs((off + np.pi) % (2 * np.pi) - np.pi)
    appears = np.arcsin(np.clip(VISIBLE_RADIUS / np.maximum(distance, VISIBLE_RADIUS), 0.0, 1.0))
    seen = (distance <= reach) & (off <= half + appears) & ~np.eye(poses.shape[-2], dtype=bool)
    return np.asarray(seen.any(axis=-1))


def read(past: Array, step: float, effects: Effects, random: np.random.Generator) -> NDArray[np.bool_]:
    """The reading that arrives now.

    A late sensor tells what was in view `delay` earlier, stamped with the moment at which it arrives. Misses go by the turn rate at the
    moment of looking.

    Args:
        past: Poses up to now, (steps, B, N, 3).
        step: Time between them, s.
        effects: The hidden effects.
        random: Source of misses and false detections.

    Returns:
        (B, N).
    """
    late = round(effects.get("sensor_delay", {}).get("delay", 0.0) / step)
    index = max(0, len(past) - 1 - late)
    view = in_view(past[index], effects)
    turning = np.abs(past[index, ..., 2] - past[max(0, index - 1), ..., 2]) / step
    miss = effects.get("missed_detections", {}).get("probability", 0.0) + effects.get("misses_when_turning", {}).get("rate", 0.0) * turning
    false = effects.get("false_detections", {}).get("probability", 0.0)
    chance = random.random(view.shape)
    return np.asarray(np.where(view, chance >= miss, chance < false))

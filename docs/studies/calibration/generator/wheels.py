"""From a command to the velocity that the robot's wheels want."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Effects = dict[str, dict[str, float]]

WHEEL_BASE = 0.063
"""Distance between the wheels, m (HeRo firmware)."""


def wanted(v_command: Array, omega_command: Array, factors: Array, t: float, effects: Effects) -> tuple[Array, Array]:
    """Settled velocity for a command that acts.

    Order, where the definitions leave it open: the deadband compares the rim speeds that were commanded, gains (with their spread and
    drift) and turning_slows act on what is left, turn_bias on the speed that results, saturation on the rim speeds that result.
    Dead time and loss come before (they are the message's), lag after, floor drift last.

    Args:
        v_command: Forward speed commanded, m/s, any shape S.
        omega_command: Turn rate commanded, rad/s, S.
        factors: Each robot's own factor on its linear and angular gain, S + (2,).
        t: Time since the start of the run, s.
        effects: The hidden effects.

    Returns:
        Forward speed in m/s and turn rate in rad/s, each S.
    """
    v, omega = v_command, omega_command
    if "deadband" in effects:
        left, right = v - omega * WHEEL_BASE / 2, v + omega * WHEEL_BASE / 2
        threshold = effects["deadband"]["threshold"]
        left = np.where(np.abs(left) < threshold, 0.0, left)
        right = np.where(np.abs(right) < threshold, 0.0, right)
        v, omega = (left + right) / 2, (right - left) / WHEEL_BASE
    fall = max(0.0, 1 - effects["gain_drift"]["rate"] * t) if "gain_drift" in effects else 1.0
    v = v * factors[..., 0] * (fall * effects.get("linear_gain", {}).get("gain", 1.0))
    omega = omega * factors[..., 1] * (fall * effects.get("angular_gain", {}).get("gain", 1.0))
    if "turning_slows" in effects:
        v = v * np.maximum(0.0, 1 - effects["turning_slows"]["slip"] * np.abs(omega_command))
    if "turn_bias" in effects:
        omega = omega + effects["turn_bias"]["bias"] * v
    if "saturation" in effects:
        limit = effects["saturation"]["limit"]
        left = np.clip(v - omega * WHEEL_BASE / 2, -limit, limit)
        right = np.clip(v + omega * WHEEL_BASE / 2, -limit, limit)
        v, omega = (left + right) / 2, (right - left) / WHEEL_BASE
    return v, omega

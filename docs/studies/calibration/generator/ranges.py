"""The effects that can be hidden, and how large they are drawn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

Bands = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class EffectRange:
    """One effect: its parameters and the runs that show it.

    Attributes:
        parameters: For each parameter its unit and the bands (low, high) that it is drawn from, each band as likely as the others.
            Bands leave out sizes too near the nominal value of the hero_plus world to show in five runs.
        procedure: "drives", "swarm" or "pushes".
    """

    parameters: dict[str, tuple[str, Bands]]
    procedure: str


def _either_sign(low: float, high: float) -> Bands:
    return ((-high, -low), (low, high))


def _one(name: str, unit: str, bands: Bands, procedure: str) -> EffectRange:
    return EffectRange({name: (unit, bands)}, procedure)


EFFECTS: dict[str, EffectRange] = {
    "linear_gain": _one("gain", "1", ((0.7, 0.95), (1.05, 1.3)), "drives"),
    "angular_gain": _one("gain", "1", ((0.7, 0.95), (1.05, 1.3)), "drives"),
    "turn_bias": _one("bias", "rad/m", _either_sign(0.15, 1.5), "drives"),
    "dead_time": _one("delay", "s", ((0.05, 0.4),), "drives"),
    "motor_lag": _one("time_constant", "s", ((0.08, 0.5),), "drives"),
    "deadband": _one("threshold", "m/s", ((0.012, 0.04),), "drives"),
    "saturation": _one("limit", "m/s", ((0.06, 0.12),), "drives"),
    "command_loss": _one("probability", "1", ((0.08, 0.4),), "drives"),
    "gain_drift": _one("rate", "1/s", ((0.003, 0.012),), "drives"),
    "floor_drift": EffectRange({"vx": ("m/s", _either_sign(0.003, 0.015)), "vy": ("m/s", _either_sign(0.003, 0.015))}, "drives"),
    "start_kick": EffectRange({"mean": ("rad", ((-0.12, 0.12),)), "sd": ("rad", ((0.04, 0.15),))}, "drives"),
    "turning_slows": _one("slip", "s/rad", ((0.06, 0.3),), "drives"),
    "robot_spread": _one("sd", "1", ((0.05, 0.15),), "drives"),
    "detection_range": _one("range", "m", ((0.4, 0.8), (1.2, 1.5)), "swarm"),
    "field_of_view": _one("half_angle", "rad", ((0.04, 0.085), (0.16, 0.35)), "swarm"),
    "sensor_yaw": _one("yaw", "rad", _either_sign(0.06, 0.3), "swarm"),
    "missed_detections": _one("probability", "1", ((0.05, 0.4),), "swarm"),
    "misses_when_turning": _one("rate", "s/rad", ((0.12, 0.5),), "swarm"),
    "false_detections": _one("probability", "1", ((0.01, 0.15),), "swarm"),
    "sensor_delay": _one("delay", "s", ((0.1, 0.6),), "swarm"),
    "robot_friction": _one("coefficient", "1", ((0.0, 0.1), (0.6, 1.0)), "pushes"),
    "wall_friction": _one("coefficient", "1", ((0.0, 0.15), (0.8, 1.2)), "pushes"),
    "collision_radius": _one("radius", "m", ((0.045, 0.055), (0.065, 0.08)), "pushes"),
    "marker_yaw": _one("yaw", "rad", _either_sign(0.03, 0.3), "drives"),
    "clock_offset": _one("offset", "s", _either_sign(0.05, 0.3), "drives"),
}
"""The effects by name. Units are SI; nominal values are those of the hero_plus world: friction 0.3 (robots) and 0.4 (walls),
radius 0.06 m, range 1 m, half angle 0.12 rad."""

WHOLE_STEPS = {"dead_time", "sensor_delay"}
"""Effects drawn in whole milliseconds, the generator's step, so that the number drawn is exactly the number acted out."""


def draw(names: list[str] | tuple[str, ...], seed: int) -> dict[str, dict[str, float]]:
    """Draw a size for each named effect.

    Args:
        names: Effects of `EFFECTS`.
        seed: Seed; the same names and seed give the same sizes.

    Returns:
        For each effect its parameters, in the units of `EFFECTS`.
    """
    random = np.random.default_rng([seed, 1])
    drawn: dict[str, dict[str, float]] = {}
    for name in names:
        drawn[name] = {}
        for parameter, (_, bands) in EFFECTS[name].parameters.items():
            low, high = bands[random.integers(len(bands))]
            value = float(random.uniform(low, high))
            drawn[name][parameter] = round(value, 3) if name in WHOLE_STEPS else value
    return drawn

"""The effects of the sensor that may be named, and the model that they are numbers of."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from swarm_envs.calibration.selection.one_number import Effect, Numbers
from swarm_envs.worlds import Effects, WorldSpec


@dataclass(frozen=True)
class SensorModel(Numbers):
    """One robot's sensor; a number that an effect may change has the effect's name."""

    detection_range: float
    """m."""
    field_of_view: float
    """To each side, in rad."""
    sensor_yaw: float
    """Direction of the middle of the sensor's sector from the heading, in rad; the effect's own number is without the sensor's bearing."""
    missed_detections: float
    """Probability."""
    misses_when_turning: float
    """Probability per rad/s."""
    false_detections: float
    """Probability."""
    sensor_delay: float
    """s."""
    log_noise_scale: float = 0.0
    """Logarithm of how much wider the edges of the sector are than the tracker's noise makes them."""

    @classmethod
    def of(cls, world: WorldSpec) -> SensorModel:
        """Return the first sensor of a world's first robot."""
        sensor, effects = world.robots[0].sensors[0], world.robots[0].effects
        return cls(
            sensor.range, sensor.half_angle, sensor.bearing + effects.sensor_yaw, effects.missed_detections, effects.misses_when_turning,
            effects.false_detections, effects.sensor_delay,
        )  # fmt: skip


NOISE_SCALE = "log_noise_scale"
"""The number that is fitted in every model."""


@dataclass(frozen=True)
class SensorEffect(Effect):
    """An effect of the sensor that may be named."""

    low: float
    """Smallest value searched."""
    high: float
    """Largest value searched."""


def _declared(name: str, parameter: str, minimum_effect: float, sentence: str) -> SensorEffect:
    """Return a candidate whose unit and bounds are those of the effect's declaration."""
    declaration = next(field.metadata for field in dataclasses.fields(Effects) if field.name == name)
    low, high = declaration["search"]
    return SensorEffect(name, parameter, f"effects.{name}", declaration["unit"], minimum_effect, sentence, low, high)


EFFECTS: tuple[SensorEffect, ...] = (
    SensorEffect("detection_range", "range", "sensors.range", "m", 0.005, "It sees robots up to {range:.3g} m away.", 0.05, 4.0),
    SensorEffect(
        "field_of_view", "half_angle", "sensors.half_angle", "rad", 0.004, "It sees {half_angle:.3g} rad to each side.", 0.005, 1.5
    ),
    _declared("sensor_yaw", "yaw", 0.004, "Its sensor is turned by {yaw:.3g} rad."),
    _declared("missed_detections", "probability", 0.008, "It misses a robot in view with probability {probability:.3g}."),
    _declared("misses_when_turning", "rate", 0.01, "It misses {rate:.3g} of readings for each rad/s of turning."),
    _declared("false_detections", "probability", 0.003, "It reports nobody as a robot with probability {probability:.3g}."),
    _declared("sensor_delay", "delay", 0.02, "A reading is {delay:.3g} s old."),
)
"""Effects of the sensor, in the order in which they are tried."""
BY_NAME = {effect.name: effect for effect in EFFECTS}

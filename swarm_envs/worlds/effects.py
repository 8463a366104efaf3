"""How a real robot departs from the ideal unicycle and the ideal sensor: the one declaration of every effect.

Name, unit, neutral value, bounds and where it acts stand here and nowhere else. World files and their error messages, the rows that
compiled code reads (:mod:`swarm_envs.simulation.effect_rows`), the choice of the fast path for ideal worlds and what a calibration
searches are derived from the fields. How an effect acts is a line of :mod:`swarm_envs.simulation.drive_law` or
:mod:`swarm_envs.simulation.sensor_law`, where the order in which they act stands, too.

Every field is neutral by default: a world without an ``effects`` section moves and senses ideally.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from enum import Enum
from typing import Any

from swarm_envs.worlds.quantity import quantity


class ActsOn(Enum):
    """What an effect changes."""

    DRIVE = "drive"
    """The way from a command to motion."""
    SPREAD = "spread"
    """How the drives of robots of one kind differ."""
    READING = "reading"
    """The way from what is in view to what a controller reads."""
    MOUNTING = "mounting"
    """Where a sensor looks."""


def effect(
    unit: str, neutral: float, acts_on: ActsOn, low: float = -math.inf, high: float = math.inf, search: tuple[float, float] | None = None
) -> Any:
    """Declare an effect.

    Args:
        unit: SI unit, ``1`` for a pure number.
        neutral: The value with which nothing departs from the ideal.
        acts_on: What it changes.
        low: Smallest value that a world may have.
        high: Largest value that a world may have.
        search: Smallest and largest value that a calibration tries; by default all that a world may have.
    """
    return quantity(unit, neutral, low=low, high=high, acts_on=acts_on, search=(low, high) if search is None else search)


@dataclass(frozen=True)
class Effects:
    """Departures of one robot from the ideal, each with a neutral default."""

    linear_gain: float = effect("1", 1.0, ActsOn.DRIVE, 0.0, 1000.0, search=(1e-4, 1000.0))
    """Driven forward speed = gain x commanded; commands in a driver's own units have gains far from one."""
    angular_gain: float = effect("1", 1.0, ActsOn.DRIVE, 0.0, 1000.0, search=(1e-4, 1000.0))
    """Driven turn rate = gain x commanded."""
    turn_bias: float = effect("rad/m", 0.0, ActsOn.DRIVE, -50.0, 50.0)
    """Turn per metre driven, counter-clockwise: omega += turn_bias * v."""
    dead_time: float = effect("s", 0.0, ActsOn.DRIVE, 0.0, 3.0, search=(0.0, 2.0))
    """Commands act this much later than they are given."""
    motor_lag: float = effect("s", 0.0, ActsOn.DRIVE, 0.0, 5.0, search=(1e-3, 5.0))
    """Time constant of the first-order response of v and omega."""
    deadband: float = effect("m/s", 0.0, ActsOn.DRIVE, 0.0, 1.0)
    """A wheel whose commanded rim speed is below this stands still."""
    saturation: float = effect("m/s", math.inf, ActsOn.DRIVE, 0.0, search=(1e-3, 100.0))
    """Rim speed of a wheel is clipped to this."""
    command_loss: float = effect("1", 0.0, ActsOn.DRIVE, 0.0, 1.0, search=(1e-4, 0.95))
    """Probability that a command is lost and the previous one stays in force."""
    gain_drift: float = effect("1/s", 0.0, ActsOn.DRIVE, -0.1, 0.1)
    """Both gains fall through a run as 1 - gain_drift * t, never below zero."""
    floor_drift_x: float = effect("m/s", 0.0, ActsOn.DRIVE, -1.0, 1.0)
    """Constant velocity along x of the arena while the robot drives or turns."""
    floor_drift_y: float = effect("m/s", 0.0, ActsOn.DRIVE, -1.0, 1.0)
    """Constant velocity along y of the arena while the robot drives or turns."""
    start_kick_mean: float = effect("rad", 0.0, ActsOn.DRIVE, -math.pi, math.pi, search=(-3.0, 3.0))
    """Mean turn at each start from rest."""
    start_kick_sd: float = effect("rad", 0.0, ActsOn.DRIVE, 0.0, math.pi, search=(1e-4, 3.0))
    """Standard deviation of the turn at each start from rest."""
    turning_slows: float = effect("s/rad", 0.0, ActsOn.DRIVE, 0.0, 10.0)
    """Forward speed falls with the commanded turn: v *= 1 - turning_slows * abs(omega), never below zero."""
    linear_gain_spread: float = effect("1", 0.0, ActsOn.SPREAD, 0.0, 1.0)
    """Standard deviation, over robots, of a factor on the linear gain with mean one."""
    angular_gain_spread: float = effect("1", 0.0, ActsOn.SPREAD, 0.0, 1.0)
    """Standard deviation, over robots, of a factor on the angular gain with mean one."""
    sensor_yaw: float = effect("rad", 0.0, ActsOn.MOUNTING, -math.pi, math.pi, search=(-1.5, 1.5))
    """Every sensor of the robot is mounted turned by this, counter-clockwise."""
    missed_detections: float = effect("1", 0.0, ActsOn.READING, 0.0, 1.0, search=(0.0, 0.98))
    """Probability that a reading misses a robot in view."""
    misses_at_full_range: float = effect("1", 0.0, ActsOn.READING, 0.0, 1.0)
    """Added miss probability at the end of the sensor's range, rising from zero with the square of the distance to the nearest robot."""
    misses_when_turning: float = effect("s/rad", 0.0, ActsOn.READING, 0.0, 100.0, search=(0.0, 3.0))
    """Miss probability added per rad/s of turning."""
    misses_when_driving: float = effect("s/m", 0.0, ActsOn.READING, 0.0, 1000.0)
    """Miss probability added per m/s of driving."""
    false_detections: float = effect("1", 0.0, ActsOn.READING, 0.0, 1.0, search=(0.0, 0.98))
    """Probability that a reading with nothing in view reports a robot."""
    sensor_delay: float = effect("s", 0.0, ActsOn.READING, 0.0, 3.0, search=(0.0, 1.5))
    """A reading reaches the controller this much late (rounded to whole ticks)."""

    def neutral(self, *acts_on: ActsOn) -> bool:
        """Whether no effect that acts there departs from the ideal."""
        return all(getattr(self, f.name) == f.default for f in dataclasses.fields(Effects) if f.metadata["acts_on"] in acts_on)

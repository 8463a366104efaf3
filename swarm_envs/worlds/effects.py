"""How a real robot departs from the ideal unicycle and the ideal sensor.

Every field is neutral by default: a world without an ``effects`` section moves and senses ideally. The order in which the
drive's effects act is that of :mod:`swarm_envs.simulation.actuation`, the sensor's that of :mod:`swarm_envs.simulation.sensing`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from swarm_envs.worlds.quantity import quantity


@dataclass(frozen=True)
class Effects:
    """Departures of one robot from the ideal, each with a neutral default."""

    linear_gain: float = quantity("1", 1.0, low=0.0, high=100.0)
    """Driven forward speed = gain x commanded."""
    angular_gain: float = quantity("1", 1.0, low=0.0, high=100.0)
    """Driven turn rate = gain x commanded."""
    turn_bias: float = quantity("rad/m", 0.0, low=-50.0, high=50.0)
    """Turn per metre driven, counter-clockwise: omega += turn_bias * v."""
    dead_time: float = quantity("s", 0.0, low=0.0, high=3.0)
    """Commands act this much later than they are given."""
    motor_lag: float = quantity("s", 0.0, low=0.0, high=5.0)
    """Time constant of the first-order response of v and omega."""
    deadband: float = quantity("m/s", 0.0, low=0.0, high=1.0)
    """A wheel whose commanded rim speed is below this stands still."""
    saturation: float = quantity("m/s", math.inf, low=0.0)
    """Rim speed of a wheel is clipped to this."""
    command_loss: float = quantity("1", 0.0, low=0.0, high=1.0)
    """Probability that a command is lost and the previous one stays in force."""
    gain_drift: float = quantity("1/s", 0.0, low=-0.1, high=0.1)
    """Both gains fall through a run as 1 - gain_drift * t, never below zero."""
    floor_drift_x: float = quantity("m/s", 0.0, low=-1.0, high=1.0)
    """Constant velocity along x of the arena while the robot drives or turns."""
    floor_drift_y: float = quantity("m/s", 0.0, low=-1.0, high=1.0)
    """Constant velocity along y of the arena while the robot drives or turns."""
    start_kick_mean: float = quantity("rad", 0.0, low=-math.pi, high=math.pi)
    """Mean turn at each start from rest."""
    start_kick_sd: float = quantity("rad", 0.0, low=0.0, high=math.pi)
    """Standard deviation of the turn at each start from rest."""
    turning_slows: float = quantity("s/rad", 0.0, low=0.0, high=10.0)
    """Forward speed falls with the commanded turn: v *= 1 - turning_slows * abs(omega), never below zero."""
    linear_gain_spread: float = quantity("1", 0.0, low=0.0, high=1.0)
    """Standard deviation, over robots, of a factor on the linear gain with mean one."""
    angular_gain_spread: float = quantity("1", 0.0, low=0.0, high=1.0)
    """Standard deviation, over robots, of a factor on the angular gain with mean one."""
    sensor_yaw: float = quantity("rad", 0.0, low=-math.pi, high=math.pi)
    """Every sensor of the robot is mounted turned by this, counter-clockwise."""
    missed_detections: float = quantity("1", 0.0, low=0.0, high=1.0)
    """Probability that a reading misses a robot in view."""
    misses_at_full_range: float = quantity("1", 0.0, low=0.0, high=1.0)
    """Added miss probability at the end of the sensor's range, rising from zero with the square of the distance to the nearest robot."""
    misses_when_turning: float = quantity("s/rad", 0.0, low=0.0, high=100.0)
    """Miss probability added per rad/s of turning."""
    misses_when_driving: float = quantity("s/m", 0.0, low=0.0, high=1000.0)
    """Miss probability added per m/s of driving."""
    false_detections: float = quantity("1", 0.0, low=0.0, high=1.0)
    """Probability that a reading with nothing in view reports a robot."""
    sensor_delay: float = quantity("s", 0.0, low=0.0, high=3.0)
    """A reading reaches the controller this much late (rounded to whole ticks)."""

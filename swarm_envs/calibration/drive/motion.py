"""From commands at any times to motion: the drive of :mod:`swarm_envs.simulation.actuation` without a tick, and without contact.

A command that the simulation would hold for whole ticks is here in force from its own time to the next one's, so that a log at any
rate can be predicted. Semantics and order of the effects are the simulation's; a test holds the two together.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.arrays import FloatArray, IntArray
from swarm_envs.calibration.logs.log import Track
from swarm_envs.compiled import compiled
from swarm_envs.worlds import Effects, WorldSpec

PARAMETERS = (
    "linear_gain", "angular_gain", "turn_bias", "dead_time", "motor_lag", "deadband", "saturation", "command_loss", "gain_drift",
    "floor_drift_x", "floor_drift_y", "start_kick_mean", "start_kick_sd", "turning_slows", "marker_yaw", "wheel_base",
)  # fmt: skip
"""Names of a drive's parameters in the order of its vector: fields of :class:`Effects`, and two more.

``marker_yaw`` (rad) is the tracker's: the measured heading is the robot's plus this. ``wheel_base`` (m) is the world's.
"""
INDEX = {name: index for index, name in enumerate(PARAMETERS)}
(
    LINEAR_GAIN, ANGULAR_GAIN, TURN_BIAS, DEAD_TIME, MOTOR_LAG, DEADBAND, SATURATION, COMMAND_LOSS, GAIN_DRIFT,
    FLOOR_X, FLOOR_Y, KICK_MEAN, KICK_SD, TURNING_SLOWS, MARKER_YAW, WHEEL_BASE,
) = range(len(PARAMETERS))  # fmt: skip
LONGEST_STEP = 0.05
"""Time in s over which a lagged speed is taken as its mean."""


def drive_parameters(world: WorldSpec) -> FloatArray:
    """Return the (16,) parameters of a world's first robot, in the order of :data:`PARAMETERS`."""
    effects: Effects = world.robots[0].effects
    values = [float(getattr(effects, name)) for name in PARAMETERS[:-2]]
    return np.array([*values, 0.0, world.robots[0].drive.wheel_base])


@compiled(_nrt=False)
def target(p: FloatArray, gain: FloatArray, v: float, omega: float, now: float) -> tuple[float, float]:
    """Return what the motors are asked for at a time, v in m/s and omega in rad/s.

    Args:
        p: (16,) parameters.
        gain: (2,) the robot's own factors on both gains.
        v: Commanded, in m/s.
        omega: Commanded, in rad/s.
        now: Time since the start of the run in s.
    """
    base = p[WHEEL_BASE]
    if p[DEADBAND] > 0.0:
        left = v - 0.5 * base * omega
        right = v + 0.5 * base * omega
        left = 0.0 if abs(left) < p[DEADBAND] else left
        right = 0.0 if abs(right) < p[DEADBAND] else right
        v, omega = 0.5 * (left + right), (right - left) / base
    v *= max(0.0, 1.0 - p[TURNING_SLOWS] * abs(omega))
    drifted = max(0.0, 1.0 - p[GAIN_DRIFT] * now)
    v *= p[LINEAR_GAIN] * gain[0] * drifted
    omega *= p[ANGULAR_GAIN] * gain[1] * drifted
    if p[SATURATION] < math.inf:
        left = min(max(v - 0.5 * base * omega, -p[SATURATION]), p[SATURATION])
        right = min(max(v + 0.5 * base * omega, -p[SATURATION]), p[SATURATION])
        v, omega = 0.5 * (left + right), (right - left) / base
    return v, omega


@compiled(_nrt=False)
def lag(now: float, goal: float, duration: float, time_constant: float) -> tuple[float, float]:
    """Return a first-order response's mean over ``duration`` s and its value after it."""
    if time_constant <= 1e-9:
        return goal, goal
    left = math.exp(-duration / time_constant)
    return goal + (now - goal) * time_constant / duration * (1.0 - left), goal + (now - goal) * left


@compiled(_nrt=False)
def sinc(x: float) -> float:
    """Return sin(x) / x."""
    return math.sin(x) / x if abs(x) > 1e-4 else 1.0 - x * x / 6.0


@compiled(_nrt=False)
def run_freely(
    p: FloatArray, gain: FloatArray, command_times: FloatArray, commands: FloatArray, times: FloatArray, out: FloatArray
) -> None:
    """Write where a robot that starts at the origin at rest would be; kicks have their mean, no command is lost.

    Args:
        p: (16,) parameters.
        gain: (2,) the robot's own factors on both gains.
        command_times: (M,) s, rising.
        commands: (M, 2) m/s and rad/s.
        times: (T,) s, rising.
        out: (T, 5) written: x, y in m and heading in rad without the floor's drift; the floor's drift in x and y in m.
    """
    x = y = theta = drift_x = drift_y = motor_v = motor_omega = 0.0
    held_v = held_omega = 0.0
    moving = False
    next_command = 0
    count = command_times.shape[0]
    now = times[0]
    if count > 0:
        now = min(now, command_times[0] + p[DEAD_TIME])
    for n in range(times.shape[0]):
        # a command given at the very time of a pose shows after it
        while now < times[n]:
            while next_command < count and command_times[next_command] + p[DEAD_TIME] <= now + 1e-12:
                held_v, held_omega = commands[next_command, 0], commands[next_command, 1]
                next_command += 1
                v, omega = target(p, gain, held_v, held_omega, now)
                if (v != 0.0 or omega != 0.0) and not moving:
                    theta += p[KICK_MEAN]
                moving = v != 0.0 or omega != 0.0
            until = min(times[n], now + LONGEST_STEP)
            if next_command < count:
                until = min(until, command_times[next_command] + p[DEAD_TIME])
            dt = until - now
            goal_v, goal_omega = target(p, gain, held_v, held_omega, now + 0.5 * dt)
            v, motor_v = lag(motor_v, goal_v, dt, p[MOTOR_LAG])
            omega, motor_omega = lag(motor_omega, goal_omega, dt, p[MOTOR_LAG])
            half = 0.5 * (omega + p[TURN_BIAS] * v) * dt
            chord = v * sinc(half) * dt
            x += chord * math.cos(theta + half)
            y += chord * math.sin(theta + half)
            theta += 2.0 * half
            if moving:
                drift_x += p[FLOOR_X] * dt
                drift_y += p[FLOOR_Y] * dt
            now = until
        out[n, 0] = x
        out[n, 1] = y
        out[n, 2] = theta
        out[n, 3] = drift_x
        out[n, 4] = drift_y


@dataclass(frozen=True)
class FreeRun:
    """A track's motion as the commands alone would have it, from the origin; see :meth:`from_pose` for any other start."""

    path: FloatArray
    """(T, 3) x, y in m and heading in rad at the track's times."""
    drift: FloatArray
    """(T, 2) displacement by the floor's drift in m."""
    marker_yaw: float
    """Measured heading minus the robot's, in rad."""

    def from_pose(self, start: int, pose: FloatArray, ends: IntArray | slice) -> FloatArray:
        """Return the predicted measured poses (K, 3) at the times ``ends``, when the measured pose at index ``start`` is ``pose``."""
        turn = pose[2] - self.marker_yaw - self.path[start, 2]
        gone = self.path[ends, :2] - self.path[start, :2]
        c, s = math.cos(turn), math.sin(turn)
        place = pose[:2] + gone @ np.array([[c, s], [-s, c]]) + self.drift[ends] - self.drift[start]
        heading = pose[2] + self.path[ends, 2] - self.path[start, 2]
        return np.column_stack([place, heading])


def free_run(parameters: FloatArray, track: Track, gain: FloatArray | None = None) -> FreeRun:
    """Return a track's motion by its commands alone.

    Args:
        parameters: (16,) in the order of :data:`PARAMETERS`.
        track: The track.
        gain: (2,) the robot's own factors on both gains; one each by default.
    """
    out = np.empty((len(track.times), 5))
    run_freely(parameters, np.ones(2) if gain is None else gain, track.command_times, track.commands, track.times, out)
    return FreeRun(out[:, :3], out[:, 3:], float(parameters[MARKER_YAW]))

"""From commands at any times to motion: :mod:`swarm_envs.simulation.drive_law` without a tick, and without contact.

A command that the simulation would hold for whole ticks is here in force from its own time to the next one's, so that a log at any
rate can be predicted.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.arrays import FloatArray, IntArray
from swarm_envs.calibration.drive.parameters import INDEX, DriveParameters, as_drives
from swarm_envs.calibration.logs.log import Track
from swarm_envs.compiled import compiled
from swarm_envs.simulation.drive_law import asks_to_move, floor_drift, goal_velocity, motion_toward, start_kick, time_of_effect

LONGEST_STEP = 0.05
"""Time in s over which a lagged speed is taken as its mean."""


@compiled(forceinline=True, _nrt=False)
def goal_at(drive: DriveParameters, factors: FloatArray, v: float, omega: float, now: float) -> tuple[float, float]:
    """Return what the motors are asked for, in m/s and rad/s, by a command (v, omega) at a time in s.

    Args:
        drive: The robot's parameters.
        factors: (2,) the robot's own factors on both gains.
        v: Commanded, in m/s.
        omega: Commanded, in rad/s.
        now: Time since the start of the run in s.
    """
    return goal_velocity(drive.effects, drive.wheel_base, factors[0], factors[1], v, omega, now, 1.0)


@compiled(_nrt=False)
def command_delay(drives: Sequence[DriveParameters]) -> float:
    """Return how late in s commands act."""
    return time_of_effect(drives[0].effects, 0.0)


@compiled(_nrt=False)
def run_freely(
    drives: Sequence[DriveParameters], factors: FloatArray, command_times: FloatArray, commands: FloatArray, times: FloatArray,
    out: FloatArray,
) -> None:  # fmt: skip
    """Write where a robot that starts at the origin at rest would be; kicks have their mean, no command is lost.

    Args:
        drives: (1,) the robot's parameters.
        factors: (2,) the robot's own factors on both gains.
        command_times: (M,) s, rising.
        commands: (M, 2) m/s and rad/s.
        times: (T,) s, rising.
        out: (T, 5) written: x, y in m and heading in rad without the floor's drift; the floor's drift in x and y in m.
    """
    drive = drives[0]
    x = y = theta = drift_x = drift_y = motor_v = motor_omega = latched_v = latched_omega = 0.0
    moving = False
    next_command = 0
    count = command_times.shape[0]
    now = times[0]
    if count > 0:
        now = min(now, time_of_effect(drive.effects, command_times[0]))
    for n in range(times.shape[0]):
        # a command given at the very time of a pose shows after it
        while now < times[n]:
            while next_command < count and time_of_effect(drive.effects, command_times[next_command]) <= now + 1e-12:
                latched_v, latched_omega = commands[next_command, 0], commands[next_command, 1]
                next_command += 1
                goal_v, goal_omega = goal_at(drive, factors, latched_v, latched_omega, now)
                moves = asks_to_move(goal_v, goal_omega)
                if moves and not moving:
                    theta += start_kick(drive.effects, 0.0)
                moving = moves
            until = min(times[n], now + LONGEST_STEP)
            if next_command < count:
                until = min(until, time_of_effect(drive.effects, command_times[next_command]))
            dt = until - now
            goal_v, goal_omega = goal_at(drive, factors, latched_v, latched_omega, now + 0.5 * dt)
            chord, half_turn, motor_v, motor_omega = motion_toward(drive.effects, goal_v, goal_omega, motor_v, motor_omega, dt)
            x += chord * math.cos(theta + half_turn)
            y += chord * math.sin(theta + half_turn)
            theta += 2.0 * half_turn
            if moving:
                carried_x, carried_y = floor_drift(drive.effects, dt)
                drift_x += carried_x
                drift_y += carried_y
            now = until
        out[n, 0], out[n, 1], out[n, 2], out[n, 3], out[n, 4] = x, y, theta, drift_x, drift_y


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
        parameters: (P,) of the drive, see :mod:`swarm_envs.calibration.drive.parameters`.
        track: The track.
        gain: (2,) the robot's own factors on both gains; one each by default.
    """
    out = np.empty((len(track.times), 5))
    run_freely(as_drives(parameters), np.ones(2) if gain is None else gain, track.command_times, track.commands, track.times, out)
    return FreeRun(out[:, :3], out[:, 3:], float(parameters[INDEX["marker_yaw"]]))

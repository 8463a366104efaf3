"""What changes while worlds run, as arrays with a leading axis over worlds."""

from __future__ import annotations

import warnings
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from swarm_envs.simulation.parameters import FloatArray, WorldArrays


class StateArrays(NamedTuple):
    """State of W worlds (R robots, S sensors, D remembered commands, L remembered readings)."""

    keys: npt.NDArray[np.uint64]
    """(W,) key of each world's random draws."""
    ticks: npt.NDArray[np.int64]
    """(W,) ticks since the start."""
    poses: FloatArray
    """(W, R, 3) x and y in m, heading in rad (not wrapped)."""
    latched_commands: FloatArray
    """(W, R, 2) the command in force after losses, m/s and rad/s."""
    command_history: FloatArray
    """(W, R, D, 2) ring of commands in force, by tick modulo D."""
    drive_velocity: FloatArray
    """(W, R, 2) driven v in m/s and omega in rad/s, before contact."""
    moving: npt.NDArray[np.uint8]
    """(W, R) whether the drive is asked to move."""
    gains: FloatArray
    """(W, R, 2) each robot's own factors on the two gains."""
    detections: npt.NDArray[np.uint8]
    """(W, R, S) the readings that the controller has; with a broadcast one more, whether the robot hears another."""
    messages: npt.NDArray[np.uint8]
    """(W, R) what each robot broadcasts."""
    reading_history: npt.NDArray[np.uint8]
    """(W, R, S, L) ring of readings not yet delivered."""
    stalled: npt.NDArray[np.uint8]
    """(W, R) whether a touch on a wheel keeps the robot from driving."""
    objects: FloatArray
    """(W, B, 6) pushable objects: x, y, angle, vx, vy, omega."""

    @property
    def held(self) -> FloatArray:
        """Deprecated name of :attr:`latched_commands`."""
        _tell_renamed("held", "latched_commands")
        return self.latched_commands

    @property
    def history(self) -> FloatArray:
        """Deprecated name of :attr:`command_history`."""
        _tell_renamed("history", "command_history")
        return self.command_history

    @property
    def motion(self) -> FloatArray:
        """Deprecated name of :attr:`drive_velocity`."""
        _tell_renamed("motion", "drive_velocity")
        return self.drive_velocity

    @property
    def readings(self) -> npt.NDArray[np.uint8]:
        """Deprecated name of :attr:`reading_history`."""
        _tell_renamed("readings", "reading_history")
        return self.reading_history


def _tell_renamed(old: str, new: str) -> None:
    warnings.warn(f"Simulation.state.{old} is now {new}; use that", DeprecationWarning, stacklevel=3)


def empty_state(world: WorldArrays, num_worlds: int) -> StateArrays:
    """Allocate the state of ``num_worlds`` worlds, all zeros; see :mod:`swarm_envs.simulation.start` for filling it."""
    robots, sensors = world.sensors.shape[:2]
    return StateArrays(
        keys=np.zeros(num_worlds, np.uint64),
        ticks=np.zeros(num_worlds, np.int64),
        poses=np.zeros((num_worlds, robots, 3)),
        latched_commands=np.zeros((num_worlds, robots, 2)),
        command_history=np.zeros((num_worlds, robots, world.history, 2)),
        drive_velocity=np.zeros((num_worlds, robots, 2)),
        moving=np.zeros((num_worlds, robots), np.uint8),
        gains=np.ones((num_worlds, robots, 2)),
        detections=np.zeros((num_worlds, robots, sensors + (world.broadcast_range > 0.0)), np.uint8),
        messages=np.zeros((num_worlds, robots), np.uint8),
        reading_history=np.zeros((num_worlds, robots, sensors, world.readings), np.uint8),
        stalled=np.zeros((num_worlds, robots), np.uint8),
        objects=np.zeros((num_worlds, len(world.objects), 6)),
    )

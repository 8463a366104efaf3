"""Who turns detections into commands: the agent's actions, a controller on board, or the robot's own firmware."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt

from swarm_envs.simulation import Simulation, check_controllers
from swarm_envs.simulation.stepping import control
from swarm_envs.worlds import WorldError

ROBOT_SOFTWARE = ("actions", "controller", "firmware")
ROBOT = "hero_plus"
"""The robot model that the firmware is written for."""


class RobotSoftware(Protocol):
    """Drives every robot of a world by itself."""

    def reset(self) -> None:
        """Start an episode."""

    def commands(self, simulation: Simulation) -> npt.NDArray[np.float64]:
        """Return what the robots do in the next tick, (R, 2) in m/s and rad/s."""


class Controller:
    """The if-else controller of the paper on board, without the robot's electronics: what ``swarm_envs.rollouts`` rolls out.

    Args:
        simulation: The running world.
        controller: (4,) or (R, 4) [v0, omega0, v1, omega1] in m/s and rad/s.

    Raises:
        WorldError: For a controller outside the world's limits.
    """

    def __init__(self, simulation: Simulation, controller: npt.ArrayLike) -> None:
        self._numbers = check_controllers(simulation.world, np.asarray(controller, dtype=np.float64)[None])[0]
        self._commands = np.empty((len(self._numbers), 2))

    def reset(self) -> None:
        """Remember nothing, as ever."""

    def commands(self, simulation: Simulation) -> npt.NDArray[np.float64]:
        """Look each robot's readings up."""
        readings = simulation.detections[0].reshape(len(self._numbers), -1)
        control(readings, self._numbers, self._commands)
        return self._commands


class Firmware:
    """The robot's own C code with the controller on board, through a simulated servo, encoder and range sensor.

    Args:
        simulation: The running world.
        controller: (4,) or (R, 4) [v0, omega0, v1, omega1] in m/s and rad/s.

    Raises:
        WorldError: For a controller outside the world's limits, or without what the firmware needs (a C compiler, cffi).
    """

    def __init__(self, simulation: Simulation, controller: npt.ArrayLike) -> None:
        world = simulation.world
        others = sorted({robot.name for robot in world.robots} - {ROBOT})
        if others:
            raise WorldError(f"robot_software is 'firmware', which is {ROBOT}'s; world {world.name!r} has robots of model {others[0]!r}")
        controllers = check_controllers(world, np.asarray(controller, dtype=np.float64)[None])[0]
        try:
            # only those who ask for the firmware need what it is built with
            from hero_robot.firmware import FirmwareError, FirmwareSwarm
        except ImportError as error:
            raise WorldError(f"robot_software is 'firmware', but {error.name} is missing; pip install 'swarm-envs[firmware]'") from None
        try:
            self._swarm = FirmwareSwarm(ROBOT, world.num_robots, controllers)
        except FirmwareError as error:
            raise WorldError(f"robot_software is 'firmware', but {error}") from None
        self._tick = world.tick
        self._before: npt.NDArray[np.float64] | None = None

    def reset(self) -> None:
        """Switch every robot off and on and start it."""
        self._swarm.reset()
        self._before = None

    def commands(self, simulation: Simulation) -> npt.NDArray[np.float64]:
        """Let the firmware see this tick's detections and feel how its wheels really turned in the last."""
        poses = simulation.poses[0]
        motion = None if self._before is None else self._felt(poses, self._before)
        self._before = poses.copy()
        readings = simulation.detections[0].reshape(len(poses), -1)[:, 0]
        return np.asarray(self._swarm.step(readings, self._tick, motion=motion))

    def _felt(self, poses: npt.NDArray[np.float64], before: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Forward speed and turn rate (R, 2) of the last tick; sideways sliding turns no wheel."""
        moved = poses - before
        middle = before[:, 2] + 0.5 * moved[:, 2]
        forward = moved[:, 0] * np.cos(middle) + moved[:, 1] * np.sin(middle)
        return np.stack([forward, moved[:, 2]], axis=1) / self._tick


def make_robot_software(simulation: Simulation, software: str | None, controller: npt.ArrayLike | None) -> RobotSoftware | None:
    """Return what drives the robots; None when the agent's actions do.

    Args:
        simulation: The running world.
        software: One of :data:`ROBOT_SOFTWARE`; None takes ``controller`` where one is given, else ``actions``.
        controller: The controller on board.

    Raises:
        WorldError: For unknown software, or a controller that is missing, or given though actions drive the robots.
    """
    software = software or ("actions" if controller is None else "controller")
    if software not in ROBOT_SOFTWARE:
        raise WorldError(f"robot_software is {software!r}, expected one of {', '.join(ROBOT_SOFTWARE)}")
    if software == "actions":
        if controller is not None:
            raise WorldError("controller is given, but robot_software is 'actions': leave robot_software out, or drive by actions")
        return None
    if controller is None:
        raise WorldError(f"robot_software is {software!r}, which needs controller=[v0, omega0, v1, omega1] in m/s and rad/s")
    return Firmware(simulation, controller) if software == "firmware" else Controller(simulation, controller)

"""The robot's own firmware, compiled for this machine and driven from Python.

The C core of ``firmware/`` is built on first use with the system's C compiler. :class:`FirmwareSwarm` lets it drive the robots
of a simulation; :class:`SimulatedBoard` is one robot with its inside laid open.
"""

from hero_robot.firmware.board import BoardView, Fault, SimulatedBoard, State
from hero_robot.firmware.errors import FirmwareError
from hero_robot.firmware.swarm import FirmwareSwarm

__all__ = ["BoardView", "Fault", "FirmwareError", "FirmwareSwarm", "SimulatedBoard", "State"]

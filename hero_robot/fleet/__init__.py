"""A fleet of robots on the lab's network: emergency stop, synchronised start, controller update, status, logs, live page.

The robots' side is ``firmware/core``; the frames between are described in ``firmware/core/hero_frame.h``.
"""

from hero_robot.fleet.delivery import Outcome
from hero_robot.fleet.errors import FleetError
from hero_robot.fleet.fleet_file import Fleet, RobotEntry, read_fleet
from hero_robot.fleet.server import FleetServer

__all__ = ["Fleet", "FleetError", "FleetServer", "Outcome", "RobotEntry", "read_fleet"]

"""The old name of :mod:`hero_robot.fleet`, kept for one version."""

import importlib
import sys
import warnings

from hero_robot.fleet import Fleet, FleetError, FleetServer, Outcome, RobotEntry, read_fleet

__all__ = ["Fleet", "FleetError", "FleetServer", "Outcome", "RobotEntry", "read_fleet"]

warnings.warn("discovery.deployment is now hero_robot.fleet; import that", DeprecationWarning, stacklevel=2)
for _name in ("command", "controller_file", "errors", "fleet_file", "frames", "robot_link", "run_log", "server", "simulated"):
    sys.modules[f"{__name__}.{_name}"] = importlib.import_module(f"hero_robot.fleet.{_name}")

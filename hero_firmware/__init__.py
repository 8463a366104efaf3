"""The old name of :mod:`hero_robot.firmware`, kept for one version."""

import importlib
import sys
import warnings

from hero_robot.firmware import BoardView, Fault, FirmwareError, FirmwareSwarm, SimulatedBoard, State

__all__ = ["BoardView", "Fault", "FirmwareError", "FirmwareSwarm", "SimulatedBoard", "State"]

warnings.warn("hero_firmware is now hero_robot.firmware; import that", DeprecationWarning, stacklevel=2)
for _name in ("board", "errors", "library", "sources", "swarm"):
    sys.modules[f"{__name__}.{_name}"] = importlib.import_module(f"hero_robot.firmware.{_name}")

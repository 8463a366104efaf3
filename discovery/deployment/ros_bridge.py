"""The old path of ``hero_robot/fleet/ros_bridge.py``, kept for one version; ROS's own Python runs it from its file."""

import runpy
import sys
from pathlib import Path

print("discovery/deployment/ros_bridge.py is now hero_robot/fleet/ros_bridge.py; use that", file=sys.stderr)
runpy.run_path(str(Path(__file__).resolve().parents[2] / "hero_robot" / "fleet" / "ros_bridge.py"), run_name=__name__)

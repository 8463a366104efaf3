"""The ROS 1 bridge on the loopback, with Debian's roscore and rospy."""

from __future__ import annotations

import csv
import json
import os
import shutil
import socket
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from hero_robot.fleet import ros_bridge
from hero_robot.fleet.command import session_path
from hero_robot.fleet.simulated import SimulatedFleet
from tests.hero_robot.fleet.serving import CONTROLLER, PATIENCE, Serving, stop_times, wait_for

pytestmark = pytest.mark.real_time

SYSTEM_PYTHON = "/usr/bin/python3"
PACKAGES = "Debian: python3-rospy python3-roslaunch rosout python3-geometry-msgs python3-std-msgs"


def has_ros() -> bool:
    if shutil.which("roscore") is None or not Path(SYSTEM_PYTHON).exists():
        return False
    return (
        subprocess.run([SYSTEM_PYTHON, "-c", "import rospy, geometry_msgs.msg, std_msgs.msg"], capture_output=True, check=False).returncode
        == 0
    )


@pytest.fixture(scope="module")
def ros(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, str]]:
    """The environment of a roscore that lives on 127.0.0.1."""
    if not has_ros():
        pytest.skip(f"ROS 1 is absent ({PACKAGES})")
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    home = tmp_path_factory.mktemp("ros")
    environment = {name: value for name, value in os.environ.items() if not name.lower().endswith("_proxy") and name != "PYTHONPATH"}
    environment |= {"ROS_MASTER_URI": f"http://127.0.0.1:{port}", "ROS_IP": "127.0.0.1", "ROS_HOME": str(home), "ROS_LOG_DIR": str(home)}
    core = subprocess.Popen(["roscore", "-p", str(port)], env=environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        wait_for(lambda: core.poll() is not None or reachable(port), PATIENCE, "roscore")
        if core.poll() is not None:
            pytest.skip(f"roscore ended by itself ({PACKAGES})")
        yield environment
    finally:
        core.terminate()
        core.wait(10)


def reachable(port: int) -> bool:
    with socket.socket() as probe:
        return probe.connect_ex(("127.0.0.1", port)) == 0


def test_topics_poses_and_stop_cross_the_bridge(ros: dict[str, str], serving: Serving, robots: SimulatedFleet, fleet_path: Path) -> None:
    serving.start_all(robots)
    bridge = subprocess.Popen([SYSTEM_PYTHON, ros_bridge.__file__, str(session_path(fleet_path))], env=ros)
    try:
        listener = Path(__file__).with_name("ros_listener.py")
        done = subprocess.run([SYSTEM_PYTHON, str(listener)], env=ros, capture_output=True, text=True, check=False, timeout=600)
        assert done.returncode == 0, done.stderr
        assert bridge.poll() is None
    finally:
        bridge.terminate()
        bridge.wait(10)
    seen = json.loads(done.stdout)
    assert {"RUN", "ESTOP"} <= set(seen["state"])
    driven = {(round(v, 3), round(omega, 3)) for v, omega in seen["cmd_vel"]}
    assert driven <= {tuple(CONTROLLER[:2]), tuple(CONTROLLER[2:]), (0.0, 0.0)}
    assert len(driven) >= 2
    assert len({tuple(pose) for pose in seen["pose"]}) > 10
    assert set(seen["detected"]) == {False, True}
    assert max(stop_times(robots, seen["pressed"])) < 0.5
    with (fleet_path.parent / "log" / "poses.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) >= 5
    assert {(row["robot"], row["y"], row["theta"]) for row in rows} == {("hero_2", "0.700000", "-1.000000")}


def test_without_a_session_one_line_says_so(tmp_path: Path) -> None:
    done = subprocess.run([SYSTEM_PYTHON, ros_bridge.__file__, str(tmp_path / "none")], capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert len(done.stderr.strip().splitlines()) == 1
    assert "session file" in done.stderr

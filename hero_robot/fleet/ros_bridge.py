"""ROS 1 bridge of a running fleet: what robots do as topics, a tracker's poses into the log, and the emergency stop.

Runs under the Python that has rospy, from its file, and needs nothing else of this project:

    python3 hero_robot/fleet/ros_bridge.py lab.session

``lab.session`` is what the server of ``lab.yaml`` leaves beside it while it runs. For each robot, at 20 Hz:

==========================  ======================  =========================================
``/<robot>/cmd_vel``        geometry_msgs/Twist     what its controller commands, published
``/<robot>/pose``           geometry_msgs/Pose2D    its odometry, published
``/<robot>/detected``       std_msgs/Bool           its detection, published
``/<robot>/state``          std_msgs/String         BOOT, HOLD, RUN, ESTOP, FAULT, published
``/<robot>/ground_pose``    geometry_msgs/Pose2D    a tracker's pose, logged
``/fleet/estop``            std_msgs/Empty          stops every robot, and latches
==========================  ======================  =========================================

ROS 1 knows no authentication: whoever reaches its master may publish. The bridge therefore stops robots and never starts them.
"""

from __future__ import annotations

import json
import sys
import urllib.request
from pathlib import Path
from typing import Any

RATE = 20.0
"""Publications per second."""

TOKEN_HEADER = "X-Fleet-Token"


class FleetClient:
    """The HTTP side of a running server."""

    def __init__(self, session_file: Path) -> None:
        session = json.loads(session_file.read_text(encoding="utf-8"))
        self.url, self.token = str(session["url"]), str(session["token"])
        self._opener = urllib.request.build_opener(urllib.request.ProxyHandler({}))  # the server is on this machine

    def status(self) -> dict[str, Any]:
        """The fleet as the server sees it."""
        with self._opener.open(self.url + "/status", timeout=1) as answer:
            return dict(json.load(answer))

    def post(self, path: str, body: dict[str, Any]) -> None:
        """Send a command."""
        request = urllib.request.Request(f"{self.url}/{path}", json.dumps(body).encode(), {TOKEN_HEADER: self.token})
        with self._opener.open(request, timeout=1):
            pass


class RobotTopics:
    """The topics of one robot."""

    def __init__(self, name: str, client: FleetClient, ros: Any) -> None:
        self.name, self.client, self.ros = name, client, ros
        publisher = ros.rospy.Publisher
        self.command = publisher(f"/{name}/cmd_vel", ros.Twist, queue_size=1)
        self.pose = publisher(f"/{name}/pose", ros.Pose2D, queue_size=1)
        self.detected = publisher(f"/{name}/detected", ros.Bool, queue_size=1)
        self.state = publisher(f"/{name}/state", ros.String, queue_size=1)
        ros.rospy.Subscriber(f"/{name}/ground_pose", ros.Pose2D, self.take_pose, queue_size=1)

    def publish(self, robot: dict[str, Any]) -> None:
        """Publish what the server says of the robot."""
        if not robot["connected"]:
            self.state.publish("not connected")
            return
        twist = self.ros.Twist()
        twist.linear.x, twist.angular.z = robot["v"], robot["omega"]
        self.command.publish(twist)
        self.pose.publish(self.ros.Pose2D(x=robot["x"], y=robot["y"], theta=robot["theta"]))
        self.detected.publish(bool(robot["detected"]))
        self.state.publish(robot["state"])

    def take_pose(self, message: Any) -> None:
        """Log a tracker's pose."""
        try:
            self.client.post("poses", {"poses": [{"robot": self.name, "x": message.x, "y": message.y, "theta": message.theta}]})
        except OSError as error:
            self.ros.rospy.logwarn_throttle(5, f"the pose of {self.name} was not logged ({error})")


def _ros() -> Any:
    """Rospy and the messages, as one namespace."""
    from types import SimpleNamespace

    try:
        import rospy  # type: ignore[import-not-found]
        from geometry_msgs.msg import Pose2D, Twist  # type: ignore[import-not-found]
        from std_msgs.msg import Bool, Empty, String  # type: ignore[import-not-found]
    except ImportError as error:
        sys.exit(
            f"{error}; the bridge runs under the Python that has rospy (Debian: python3-rospy python3-geometry-msgs, /usr/bin/python3)"
        )
    return SimpleNamespace(rospy=rospy, Pose2D=Pose2D, Twist=Twist, Bool=Bool, Empty=Empty, String=String)


def main() -> None:
    """Run the bridge until ROS ends it."""
    if len(sys.argv) < 2 or not Path(sys.argv[1]).is_file():
        sys.exit("expected the session file of a running server, such as lab.session; start it: python -m hero_robot.fleet serve lab.yaml")
    ros, client = _ros(), FleetClient(Path(sys.argv[1]))
    ros.rospy.init_node("fleet_bridge")
    ros.rospy.Subscriber("/fleet/estop", ros.Empty, lambda _: client.post("estop", {}), queue_size=1)
    topics = {robot["name"]: RobotTopics(robot["name"], client, ros) for robot in client.status()["robots"]}
    rate = ros.rospy.Rate(RATE)
    while not ros.rospy.is_shutdown():
        try:
            for robot in client.status()["robots"]:
                topics[robot["name"]].publish(robot)
        except OSError as error:
            ros.rospy.logwarn_throttle(5, f"the server does not answer ({error}); robots have stopped by themselves")
        try:
            rate.sleep()
        except ros.rospy.ROSInterruptException:
            return


if __name__ == "__main__":
    main()

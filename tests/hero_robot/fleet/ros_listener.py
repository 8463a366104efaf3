"""A ROS program of the lab, for the bridge's test; runs under the Python that has rospy.

Collects what a robot publishes, plays the tracker, presses the emergency stop, and prints what it saw as JSON.
"""

import json
import sys
import time

import rospy
from geometry_msgs.msg import Pose2D, Twist
from std_msgs.msg import Bool, Empty, String

seen = {"cmd_vel": [], "pose": [], "detected": [], "state": []}
rospy.init_node("listener")
rospy.Subscriber("/hero_2/cmd_vel", Twist, lambda m: seen["cmd_vel"].append((m.linear.x, m.angular.z)))
rospy.Subscriber("/hero_2/pose", Pose2D, lambda m: seen["pose"].append((m.x, m.y, m.theta)))
rospy.Subscriber("/hero_2/detected", Bool, lambda m: seen["detected"].append(m.data))
rospy.Subscriber("/hero_2/state", String, lambda m: seen["state"].append(m.data))
tracker = rospy.Publisher("/hero_2/ground_pose", Pose2D, queue_size=1)
stop = rospy.Publisher("/fleet/estop", Empty, queue_size=1)
deadline = time.monotonic() + 20
while time.monotonic() < deadline and (len(seen["state"]) < 40 or not tracker.get_num_connections() or not stop.get_num_connections()):
    time.sleep(0.05)
for step in range(10):
    tracker.publish(Pose2D(x=0.1 * step, y=0.7, theta=-1.0))
    time.sleep(0.05)
pressed = time.monotonic_ns()
stop.publish(Empty())
deadline = time.monotonic() + 5
while time.monotonic() < deadline and seen["state"][-1:] != ["ESTOP"]:
    time.sleep(0.05)
json.dump({"pressed": pressed, **seen}, sys.stdout)

"""Reading ROS 1 and ROS 2 bags, with a map of topics and without."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from swarm_envs.calibration import LogError, evaluate, read_log

pytest.importorskip("rosbags")

from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from rosbags.rosbag2 import Writer as Writer2
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

START = 1_700_000_000_000_000_000
ONE, TWO = get_typestore(Stores.ROS1_NOETIC), get_typestore(Stores.ROS2_HUMBLE)
Messages = list[tuple[str, str, float, object]]


def header(store, t: float, frame: str = "world"):
    types = store.types
    nanoseconds = START + round(1e9 * t)
    stamp = types["builtin_interfaces/msg/Time"](nanoseconds // 10**9, nanoseconds % 10**9)
    extra = {"seq": 0} if store is ONE else {}
    return types["std_msgs/msg/Header"](**extra, stamp=stamp, frame_id=frame)


def pose2d(store, x, y, theta):
    return store.types["geometry_msgs/msg/Pose2D"](x, y, theta)


def posed(store, t, place, quaternion):
    types = store.types
    pose = types["geometry_msgs/msg/Pose"](types["geometry_msgs/msg/Point"](*place), types["geometry_msgs/msg/Quaternion"](*quaternion))
    return types["geometry_msgs/msg/PoseStamped"](header(store, t), pose)


def transformed(store, t, frame, child, place, quaternion):
    types = store.types
    transform = types["geometry_msgs/msg/Transform"](
        types["geometry_msgs/msg/Vector3"](*place), types["geometry_msgs/msg/Quaternion"](*quaternion)
    )
    return types["geometry_msgs/msg/TransformStamped"](header(store, t, frame), child, transform)


def twist(store, v, omega):
    vector = store.types["geometry_msgs/msg/Vector3"]
    return store.types["geometry_msgs/msg/Twist"](vector(v, 0.0, 0.0), vector(0.0, 0.0, omega))


def ranged(store, t, distance):
    return store.types["sensor_msgs/msg/Range"](header(store, t), 1, 0.2, 0.04, 2.0, distance)


def yaw(angle):
    return (0.0, 0.0, math.sin(angle / 2), math.cos(angle / 2))


def write_one(path: Path, messages: Messages, store=ONE) -> Path:
    with Writer1(path) as writer:
        connections = {topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in {m[:2] for m in messages}}
        for topic, kind, t, message in sorted(messages, key=lambda entry: entry[2]):
            writer.write(connections[topic], START + round(1e9 * t), store.serialize_ros1(message, kind))
    return path


def write_two(path: Path, messages: Messages, plugin=StoragePlugin.SQLITE3, store=TWO) -> Path:
    with Writer2(path, version=9, storage_plugin=plugin) as writer:
        connections = {topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in {m[:2] for m in messages}}
        for topic, kind, t, message in sorted(messages, key=lambda entry: entry[2]):
            writer.write(connections[topic], START + round(1e9 * t), store.serialize_cdr(message, kind))
    return path


def planar(store, robot: str = "hero_1", count: int = 60) -> Messages:
    """A robot that drives along x at 0.1 m/s from 1.0 s on."""
    poses = [
        (f"/{robot}/ground_pose", "geometry_msgs/msg/Pose2D", 0.1 * k, pose2d(store, max(0.0, 0.01 * (k - 10)), 0.5, 0.0))
        for k in range(count)
    ]
    return [*poses, (f"/{robot}/cmd_vel", "geometry_msgs/msg/Twist", 1.0, twist(store, 0.1, 0.0))]


def mapped(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "topics.yaml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("write", [write_one, write_two], ids=["ros1", "ros2"])
def test_a_bag_without_a_map_is_read_by_type_and_says_how(tmp_path: Path, write) -> None:
    store = ONE if write is write_one else TWO
    log = read_log(write(tmp_path / ("run.bag" if write is write_one else "run"), planar(store)))
    (track,) = log.tracks
    assert (track.run, track.robot) == ("run", "hero_1")
    assert track.times[[0, -1]] == pytest.approx([0.0, 5.9], abs=1e-6)
    assert track.poses[-1] == pytest.approx([0.49, 0.5, 0.0])
    assert track.command_times == pytest.approx([1.0], abs=1e-6)
    assert track.commands.tolist() == [[0.1, 0.0]]
    assert any("guessed" in note and "/hero_1/ground_pose" in note for note in log.notes)
    assert evaluate("hero_plus", log)["1.0"]["position_m"] < 1e-6


def test_an_mcap_file_is_read(tmp_path: Path) -> None:
    folder = write_two(tmp_path / "run", planar(TWO), StoragePlugin.MCAP)
    assert read_log(folder).tracks[0].poses[-1] == pytest.approx([0.49, 0.5, 0.0])


def test_each_bag_is_a_run_and_a_folder_of_bags_is_all_of_them(tmp_path: Path) -> None:
    bags = [write_one(tmp_path / f"{name}.bag", planar(ONE)) for name in ("a", "b")]
    assert read_log(*bags).runs == ("a", "b")
    assert read_log(tmp_path).runs == ("a", "b")


def test_a_map_names_topics_for_all_robots_at_once(tmp_path: Path) -> None:
    bag = write_one(tmp_path / "run.bag", planar(ONE, "hero_1") + planar(ONE, "hero_2"))
    topics = "name: two\nrobots: [hero_1, hero_2]\nposes: /{robot}/ground_pose\ncommands: /{robot}/cmd_vel\noutline: [[0,0],[1,0],[1,1]]\n"
    log = read_log(bag, topics=mapped(tmp_path, topics))
    assert log.name == "two"
    assert log.robots == ("hero_1", "hero_2")
    assert log.outline == ((0, 0), (1, 0), (1, 1))


def test_poses_in_space_are_laid_on_the_floor(tmp_path: Path) -> None:
    # a tracker with y up and a body whose forward axis is z: turned by 0.4 about y
    turned = (0.0, math.sin(0.2), 0.0, math.cos(0.2))
    bag = write_one(tmp_path / "run.bag", [
        ("/mocap", "geometry_msgs/msg/PoseStamped", 0.0, posed(ONE, 0.0, (2.0, 9.0, 1.0), turned)),
        ("/hero/cmd_vel", "geometry_msgs/msg/Twist", 0.0, twist(ONE, 0.1, 0.0)),
    ])  # fmt: skip
    topics = "robots:\n  hero:\n    poses: {topic: /mocap, up: y, forward: z}\n    commands: /hero/cmd_vel\n"
    assert read_log(bag, topics=mapped(tmp_path, topics)).tracks[0].poses[0] == pytest.approx([1.0, 2.0, 0.4])


def test_transforms_are_found_by_their_frames(tmp_path: Path) -> None:
    def tf(t, frame, child, x):
        return TWO.types["tf2_msgs/msg/TFMessage"]([transformed(TWO, t, frame, child, (x, 0.0, 0.1), yaw(0.3))])

    kind = "tf2_msgs/msg/TFMessage"
    messages: Messages = [("/hero_1/cmd_vel", "geometry_msgs/msg/Twist", 0.0, twist(TWO, 0.1, 0.0))]
    for k in range(5):
        messages.append(("/tf", kind, 0.1 * k, tf(0.1 * k, "world", "hero_1/base_link", 0.1 * k)))
        messages.append(("/tf", kind, 0.1 * k + 0.01, tf(0.1 * k, "/hero_1/odom", "hero_1/base_link", 9.0)))
    bag = write_two(tmp_path / "run", messages)
    (track,) = read_log(bag).tracks
    assert track.poses[:, 0] == pytest.approx(0.1 * np.arange(5))
    assert track.poses[:, 2] == pytest.approx(np.full(5, 0.3))


def test_a_range_below_the_threshold_is_a_detection(tmp_path: Path) -> None:
    ranges = [("/hero_1/range", "sensor_msgs/msg/Range", 0.1 * k, ranged(ONE, 0.1 * k, d)) for k, d in enumerate([0.5, 0.7, 0.01, 0.3])]
    bag = write_one(tmp_path / "run.bag", planar(ONE) + ranges)
    guessed = read_log(bag).tracks[0].detections
    assert guessed.tolist() == [True, True, False, True]  # up to the sensor's own 2 m, nearer than its least range is no reading
    entries = "poses: /hero_1/ground_pose, commands: /hero_1/cmd_vel, detections: {topic: /hero_1/range, below: 0.6}"
    log = read_log(bag, topics=mapped(tmp_path, f"robots:\n  hero_1: {{{entries}}}\n"))
    assert log.tracks[0].detections.tolist() == [True, False, False, True]


def test_the_headers_clock_can_be_asked_for(tmp_path: Path) -> None:
    messages: Messages = [
        ("/hero/pose", "geometry_msgs/msg/PoseStamped", 0.2 * k + 0.07, posed(ONE, 0.2 * k, (0.0, 0.0, 0.0), yaw(0.0))) for k in range(4)
    ]
    bag = write_one(tmp_path / "run.bag", [*messages, ("/hero/cmd_vel", "geometry_msgs/msg/Twist", 0.5, twist(ONE, 0.1, 0.0))])
    stamped = "robots:\n  hero: {poses: {topic: /hero/pose, time: stamp}, commands: /hero/cmd_vel}\n"
    assert read_log(bag, topics=mapped(tmp_path, stamped)).tracks[0].command_times == pytest.approx([0.5], abs=1e-6)
    assert read_log(bag).tracks[0].command_times == pytest.approx([0.43], abs=1e-6)
    headless = "robots:\n  hero: {poses: /hero/pose, commands: {topic: /hero/cmd_vel, time: stamp}}\n"
    with pytest.raises(LogError, match=r"/hero/cmd_vel: messages have no header"):
        read_log(bag, topics=mapped(tmp_path, headless))


def test_messages_that_only_the_bag_defines_are_read(tmp_path: Path) -> None:
    store = get_typestore(Stores.ROS1_NOETIC)
    store.register(get_types_from_msg("float64 x\nfloat64 y\nfloat64 theta\nstring camera", "lab_msgs/msg/Seen"))
    seen = store.types["lab_msgs/msg/Seen"](1.0, 2.0, 0.5, "ceiling")
    bag = write_one(
        tmp_path / "run.bag",
        [("/seen", "lab_msgs/msg/Seen", 0.0, seen), ("/hero/cmd_vel", "geometry_msgs/msg/Twist", 0.1, twist(store, 0.1, 0.0))],
        store,
    )
    log = read_log(bag, topics=mapped(tmp_path, "robots:\n  hero: {poses: /seen, commands: /hero/cmd_vel}\n"))
    assert log.tracks[0].poses.tolist() == [[1.0, 2.0, 0.5]]


def test_a_choice_that_only_the_owner_can_make_is_refused_with_the_topics(tmp_path: Path) -> None:
    two = [*planar(ONE), ("/hero_1/other_pose", "geometry_msgs/msg/Pose2D", 0.0, pose2d(ONE, 0.0, 0.0, 0.0))]
    with pytest.raises(LogError, match=r"poses may be /hero_1/ground_pose or /hero_1/other_pose.*Topics: /hero_1/cmd_vel \(geometry_msgs"):
        read_log(write_one(tmp_path / "two.bag", two))
    with pytest.raises(LogError, match=r"no topic of commands.*Topics: /hero_1/ground_pose"):
        read_log(write_one(tmp_path / "none.bag", planar(ONE)[:-1]))


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("robots: {hero_1: {poses: /nothing}}\n", r"no message on /nothing, which the topic map gives as poses of hero_1. Topics: /hero_1"),
        ("robots: {hero_1: {commands: /hero_1/cmd_vel}}\n", r"robots.hero_1 has no poses"),
        ("robots: {hero_1: {poses: {topic: /p, up: q}}}\n", r"robots.hero_1.poses.up is 'q', expected one of z, y"),
        ("robots: {hero_1: {pose: /p}}\n", r"robots.hero_1.pose: unknown key; expected only commands, detections, poses"),
        ("robots: {hero_1: {poses: /hero_1/cmd_vel}}\n", r"/hero_1/cmd_vel: messages of type geometry_msgs/msg/Twist hold no pose"),
        ("- a\n", r"topics.yaml: expected a mapping"),
    ],
)
def test_a_wrong_map_is_refused(tmp_path: Path, text: str, reason: str) -> None:
    bag = write_one(tmp_path / "run.bag", planar(ONE))
    with pytest.raises(LogError, match=reason):
        read_log(bag, topics=mapped(tmp_path, text))


def test_a_damaged_bag_is_refused(tmp_path: Path) -> None:
    bag = write_one(tmp_path / "run.bag", planar(ONE))
    bag.write_bytes(bag.read_bytes()[:300])
    with pytest.raises(LogError, match=r"run.bag: cannot be read as a ROS bag"):
        read_log(bag)

"""Which topics of a bag are a robot's poses, commands and detections: from a map, or guessed by name and type."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

from swarm_envs.calibration.errors import LogError

KINDS = ("poses", "commands", "detections")
KEYS = {
    "poses": {"topic", "time", "frame", "child", "up", "forward"},
    "commands": {"topic", "time"},
    "detections": {"topic", "time", "below"},
}
CHOICES = {"time": ("receipt", "stamp"), "up": ("z", "y"), "forward": ("x", "y", "z", "-x", "-y", "-z")}
POSE_TYPES = (
    ("geometry_msgs/msg/Pose2D",),
    ("geometry_msgs/msg/PoseStamped", "geometry_msgs/msg/PoseWithCovarianceStamped", "geometry_msgs/msg/TransformStamped"),
    ("geometry_msgs/msg/Pose", "geometry_msgs/msg/PoseWithCovariance"),
)
"""Types whose topics are taken for poses, the likeliest first. Odometry is not: it is what a robot believes."""
TF_TYPES = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage")
COMMAND_TYPES = (("geometry_msgs/msg/Twist", "geometry_msgs/msg/TwistStamped"),)
LONE_ROBOT = "robot"
"""Name of a robot whose topics have no namespace."""


@dataclass(frozen=True)
class Source:
    """Where a table of a log comes from."""

    topic: str
    time: str = "receipt"
    """``receipt``: when the recorder got the message, one clock for all topics; ``stamp``: what the message's header says."""
    frame: str = ""
    """Of a tf topic: the frame of the poses; any if empty."""
    child: str = ""
    """Of a tf topic: the robot's frame."""
    up: str = "z"
    """Axis of the frame that points up, ``z`` or ``y``."""
    forward: str = "x"
    """Axis of the tracked body that points forward."""
    below: float | None = None
    """A range or number up to this, in m, is a detection."""


@dataclass(frozen=True)
class TopicMap:
    """The topics of every robot, and what a log's ``log.yaml`` would say."""

    robots: Mapping[str, Mapping[str, Source]]
    """By robot, then by table: ``poses``, ``commands``, ``detections``."""
    about: Mapping[str, Any] = field(default_factory=dict)
    """``name``, ``units`` and ``outline``, as in ``log.yaml``."""
    notes: tuple[str, ...] = ()
    """What was guessed."""


def read_topic_map(path: str | Path) -> TopicMap:
    """Return the map in a YAML file.

    ``robots`` is a mapping from name to ``poses``, ``commands`` and ``detections``, or a list of names; what stands at the top of the
    file holds for every robot, with ``{robot}`` for its name. An entry is a topic, or a mapping with ``topic`` and its choices.

    Raises:
        LogError: When the file cannot be read or says something unknown.
    """
    path = Path(path)
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise LogError(f"{path}: cannot be read ({error}); give a YAML file that maps topics") from None
    except yaml.YAMLError as error:
        raise LogError(f"{path}: not valid YAML ({' '.join(str(error).split())})") from None
    if not isinstance(document, dict):
        raise LogError(f"{path}: expected a mapping of keys, given {type(document).__name__}")
    _known(path, "", document, {"robots", "name", "units", "outline", *KINDS})
    robots = document.get("robots")
    if isinstance(robots, list):
        robots = dict.fromkeys(map(str, robots))
    if not isinstance(robots, dict) or not robots:
        raise LogError(f"{path}: robots is {robots!r}, expected a list of names, or a mapping from name to poses and commands")
    found = {}
    for name, own in robots.items():
        if own is not None and not isinstance(own, dict):
            raise LogError(f"{path}: robots.{name} is {own!r}, expected a mapping with poses and commands")
        _known(path, f"robots.{name}.", own or {}, set(KINDS))
        given = {kind: (own or {}).get(kind, document.get(kind)) for kind in KINDS}
        found[str(name)] = {
            kind: _source(path, f"robots.{name}.{kind}", kind, entry, str(name)) for kind, entry in given.items() if entry is not None
        }
        if "poses" not in found[str(name)]:
            raise LogError(f"{path}: robots.{name} has no poses; name the topic of its tracked poses")
    return TopicMap(found, {key: document[key] for key in ("name", "units", "outline") if key in document})


def _known(path: Path, where: str, given: Mapping[Any, Any], known: set[str]) -> None:
    for key in given:
        if key not in known:
            raise LogError(f"{path}: {where}{key}: unknown key; expected only {', '.join(sorted(known))}")


def _source(path: Path, where: str, kind: str, entry: Any, robot: str) -> Source:
    values = {"topic": entry} if isinstance(entry, str) else entry
    if not isinstance(values, dict) or not isinstance(values.get("topic"), str):
        raise LogError(f"{path}: {where} is {entry!r}, expected a topic, or a mapping with topic")
    _known(path, f"{where}.", values, KEYS[kind])
    for key, choices in CHOICES.items():
        if values.get(key, choices[0]) not in choices:
            raise LogError(f"{path}: {where}.{key} is {values[key]!r}, expected one of {', '.join(choices)}")
    below = values.get("below")
    if below is not None and (isinstance(below, bool) or not isinstance(below, int | float)):
        raise LogError(f"{path}: {where}.below is {below!r}, expected a number in m")
    texts = {key: value.replace("{robot}", robot) for key, value in values.items() if isinstance(value, str)}
    for key in ("frame", "child"):
        if key in texts:
            texts[key] = texts[key].strip("/")
    return Source(**texts, below=None if below is None else float(below))


def guess_topics(topics: Mapping[str, str], frames: frozenset[tuple[str, str, str]] = frozenset()) -> TopicMap:
    """Return a map by name and type of the topics: a robot is whatever has a topic of commands.

    Args:
        topics: Type of each topic.
        frames: (topic, frame, child) of every transform on topics of tf.

    Raises:
        LogError: When there is nothing to choose, or a choice that only the owner can make; the topics are listed.
    """
    robots: dict[str, dict[str, Source]] = {}
    notes = []
    for robot in sorted({_namespace(topic) for topic, kind in topics.items() if kind in COMMAND_TYPES[0]}):
        robots[robot] = {"commands": _first(robot, "commands", topics, COMMAND_TYPES), "poses": _pose_source(robot, topics, frames)}
        seen = sorted(
            topic for topic, kind in topics.items()
            if kind == "sensor_msgs/msg/Range" or (kind == "std_msgs/msg/Bool" and "detect" in topic.rsplit("/", 1)[-1])
        )  # fmt: skip
        own = [topic for topic in seen if _belongs(topic, robot)]
        if len(own) > 1:
            raise LogError(f"{robot}: detections may be {' or '.join(own)}; say which in a topic map (--topics). {_listed(topics)}")
        if own:
            robots[robot]["detections"] = Source(own[0])
        chosen = ", ".join(f"{kind} {_described(source)}" for kind, source in robots[robot].items())
        notes.append(f"guessed by type, for {robot}: {chosen}; say otherwise in a topic map (--topics)")
    if not robots:
        raise LogError(f"no topic of commands (geometry_msgs/Twist); name it in a topic map (--topics). {_listed(topics)}")
    return TopicMap(robots, notes=tuple(notes))


def _described(source: Source) -> str:
    return f"{source.topic} ({source.child} in {source.frame})" if source.child else source.topic


def _namespace(topic: str) -> str:
    return topic.strip("/").rpartition("/")[0] or LONE_ROBOT


def _belongs(topic: str, robot: str) -> bool:
    """Whether a topic is a robot's: its name is a part of the topic's."""
    return robot == LONE_ROBOT or f"/{robot}/" in f"/{topic.strip('/')}/"


def _first(robot: str, kind: str, topics: Mapping[str, str], ranked: tuple[tuple[str, ...], ...]) -> Source:
    """Return the only topic of the likeliest type that there is."""
    for types in ranked:
        found = sorted(topic for topic, given in topics.items() if given in types and _belongs(topic, robot))
        if len(found) > 1:
            raise LogError(f"{robot}: {kind} may be {' or '.join(found)}; say which in a topic map (--topics). {_listed(topics)}")
        if found:
            return Source(found[0])
    raise LogError(f"{robot}: no topic of {kind}; name it in a topic map (--topics). {_listed(topics)}")


def _pose_source(robot: str, topics: Mapping[str, str], frames: frozenset[tuple[str, str, str]]) -> Source:
    try:
        return _first(robot, "poses", topics, POSE_TYPES)
    except LogError as error:
        # a transform from odometry is what the robot believes, like the topic of that name
        mine = sorted(entry for entry in frames if _belongs(entry[2], robot) and "odom" not in entry[1])
        if " may be " in str(error) or not mine:
            raise
        if len(mine) > 1:
            names = " or ".join(f"{child} in {frame}" for _, frame, child in mine)
            raise LogError(f"{robot}: poses may be {names}; say which in a topic map (--topics). {_listed(topics)}") from None
        topic, frame, child = mine[0]
        return Source(topic, frame=frame, child=child)


def _listed(topics: Mapping[str, str]) -> str:
    return "Topics: " + ", ".join(f"{topic} ({kind})" for topic, kind in sorted(topics.items()))

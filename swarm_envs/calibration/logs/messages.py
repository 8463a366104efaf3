"""What a ROS message says: a pose on the floor, a command, or whether something is seen. Messages are told apart by their fields."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from swarm_envs.calibration.errors import LogError
from swarm_envs.calibration.logs.topics import Source

Numbers = tuple[float, ...]
GROUND = {"z": (0, 1), "y": (2, 0)}
"""Axes of the floor, x and y of the log, where that axis points up."""


def stamp(message: Any) -> float | None:
    """Return the time in a message's own header in s, or None where it has none."""
    header = getattr(message, "header", None)
    return None if header is None else float(header.stamp.sec) + 1e-9 * float(header.stamp.nanosec)


def read_poses(message: Any, source: Source) -> Iterator[tuple[float | None, Numbers]]:
    """Yield the poses (x in m, y in m, heading in rad) in a message, each with its own stamp in s if it has one.

    Raises:
        LogError: When the message holds no pose.
    """
    if hasattr(message, "transforms"):
        for transform in message.transforms:
            frames = (transform.header.frame_id.strip("/"), transform.child_frame_id.strip("/"))
            if frames[1] == source.child and source.frame in ("", frames[0]):
                yield stamp(transform), _flat(transform.transform.translation, transform.transform.rotation, source)
        return
    time = stamp(message)
    while not hasattr(message, "position") and hasattr(message, "pose"):
        message = message.pose
    if hasattr(message, "transform"):
        yield time, _flat(message.transform.translation, message.transform.rotation, source)
    elif hasattr(message, "position") and hasattr(message, "orientation"):
        yield time, _flat(message.position, message.orientation, source)
    elif all(hasattr(message, name) for name in ("x", "y", "theta")):
        yield time, (float(message.x), float(message.y), float(message.theta))
    else:
        raise LogError(f"{source.topic}: messages of type {_name(message)} hold no pose; map a topic of poses")


def read_command(message: Any, source: Source) -> tuple[float | None, Numbers]:
    """Return a message's stamp, if any, and its command (v, omega).

    Raises:
        LogError: When the message holds no velocity.
    """
    time = stamp(message)
    message = getattr(message, "twist", message)
    if not hasattr(message, "linear") or not hasattr(message, "angular"):
        raise LogError(f"{source.topic}: messages of type {_name(message)} hold no velocity; map a topic of geometry_msgs/Twist")
    return time, (float(message.linear.x), float(message.angular.z))


def read_detection(message: Any, source: Source) -> tuple[float | None, Numbers]:
    """Return a message's stamp, if any, and 1.0 if it tells of something seen, else 0.0.

    A range counts when it is at most the map's ``below`` (without it: the message's own ``max_range``), a number when it is at most
    ``below``, a truth value as it is.

    Raises:
        LogError: When the message holds neither, or a number has no threshold.
    """
    time = stamp(message)
    if hasattr(message, "range"):
        limit = source.below if source.below is not None else float(message.max_range)
        seen = float(message.min_range) <= float(message.range) <= limit
    elif isinstance(getattr(message, "data", None), bool | np.bool_):
        seen = bool(message.data)
    elif isinstance(getattr(message, "data", None), int | float | np.number):
        if source.below is None:
            raise LogError(f"{source.topic}: numbers need a threshold; write {{topic: {source.topic}, below: VALUE}} in the map")
        seen = float(message.data) <= source.below
    else:
        raise LogError(f"{source.topic}: messages of type {_name(message)} tell of no detection; map std_msgs/Bool or sensor_msgs/Range")
    return time, (float(seen),)


def _flat(place: Any, turn: Any, source: Source) -> Numbers:
    """Return the floor's part of a pose in space: the robot's forward axis gives the heading."""
    x, y = GROUND[source.up]
    where = (float(place.x), float(place.y), float(place.z))
    ahead = _turned(source.forward, float(turn.w), np.array([turn.x, turn.y, turn.z], float))
    return where[x], where[y], math.atan2(ahead[y], ahead[x])


def _turned(axis: str, w: float, v: Any) -> Any:
    """Return an axis (``x``, ``-x``, ...) turned by a quaternion."""
    unit = np.zeros(3)
    unit["xyz".index(axis[-1])] = -1.0 if axis.startswith("-") else 1.0
    norm = w * w + float(v @ v)
    if not norm > 0.0:
        return np.full(3, math.nan)
    cross = 2.0 * np.cross(v, unit) / norm
    return unit + w * cross + np.cross(v, cross)


def _name(message: Any) -> str:
    return str(getattr(message, "__msgtype__", type(message).__name__))

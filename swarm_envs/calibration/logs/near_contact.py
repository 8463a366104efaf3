"""Where in a log robots may have touched each other or a wall."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from swarm_envs.calibration.arrays import BoolArray
from swarm_envs.calibration.logs.log import Log, Track
from swarm_envs.simulation.segments import distances_to_segments, polygon_edges

REACH = 0.09
"""Robots whose centres are within twice this, m, or within this of a wall may touch: any HeRo's radius, and room for error."""


def may_touch(log: Log, tracks: Sequence[Track]) -> list[BoolArray]:
    """Return for each track (T,) whether the robot is so near a wall or another robot of its run that they may touch."""
    result = []
    for track in tracks:
        touching = np.zeros(len(track.times), bool)
        if log.outline is not None:
            touching |= distances_to_segments(np.ascontiguousarray(track.poses[:, :2]), polygon_edges(np.array(log.outline))) < REACH
        for other in tracks:
            if other is not track and other.run == track.run:
                place = np.column_stack([np.interp(track.times, other.times, other.poses[:, k]) for k in range(2)])
                touching |= np.hypot(*(place - track.poses[:, :2]).T) < 2 * REACH
        result.append(touching)
    return result

"""Segments: the walls of a world as such, and the one distance from a point to a segment."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from swarm_envs.compiled import compiled
from swarm_envs.worlds.spec import Polygon, WorldSpec

FloatArray = npt.NDArray[np.float64]


def polygon_edges(outline: Polygon | FloatArray) -> FloatArray:
    """Edges of a closed polygon, (corners, 4): x and y of both ends in m."""
    ring = np.array(outline, dtype=np.float64)
    return np.concatenate([ring, np.roll(ring, -1, axis=0)], axis=1)


def wall_segments(world: WorldSpec) -> FloatArray:
    """Edges of the arena's outline and of its obstacles, (edges, 4): x and y of both ends in m."""
    return np.concatenate([polygon_edges(ring) for ring in (world.arena.outline, *(o.outline for o in world.arena.obstacles))])


@compiled(forceinline=True, _nrt=False)
def offset_from_segment(x: float, y: float, along_x: float, along_y: float, squared: float, end: float) -> tuple[float, float]:
    """Return the way in m from a segment's nearest point to a point.

    Args:
        x: The point's, from the segment's start, in m.
        y: The same.
        along_x: A vector along the segment, in m or of length 1.
        along_y: The same.
        squared: The vector's squared length.
        end: The segment's end as a multiple of the vector.
    """
    share = min(max((x * along_x + y * along_y) / squared, 0.0), end)
    return x - share * along_x, y - share * along_y


@compiled()
def segment_distance(x: float, y: float, segment: FloatArray) -> float:
    """Distance in m from a point to a segment (4,): x and y of both ends in m."""
    along_x, along_y = segment[2] - segment[0], segment[3] - segment[1]
    squared = along_x * along_x + along_y * along_y
    offset_x, offset_y = offset_from_segment(x - segment[0], y - segment[1], along_x, along_y, squared if squared > 0.0 else 1.0, 1.0)
    return float(math.hypot(offset_x, offset_y))


@compiled()
def nearest_segment(x: float, y: float, segments: FloatArray) -> tuple[float, int]:
    """Distance in m from a point to the nearest of segments (E, 4), and that one's index."""
    least, nearest = math.inf, 0
    for k in range(segments.shape[0]):
        distance = segment_distance(x, y, segments[k])
        if distance < least:
            least, nearest = distance, k
    return least, nearest


@compiled()
def distances_to_segments(points: FloatArray, segments: FloatArray) -> FloatArray:
    """Distance in m from each point (T, 2) to the nearest of segments (E, 4): (T,)."""
    out = np.empty(points.shape[0])
    for k in range(points.shape[0]):
        out[k] = nearest_segment(points[k, 0], points[k, 1], segments)[0]
    return out

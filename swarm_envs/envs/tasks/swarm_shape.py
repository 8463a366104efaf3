"""What several tasks look at: a swarm's centroid, and how its robots stand and move around it. Compiled."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from swarm_envs import metrics
from swarm_envs.behaviours import HEXAGONAL_DENSITY
from swarm_envs.compiled import compiled
from swarm_envs.simulation.segments import nearest_segment
from swarm_envs.worlds import WorldSpec

FloatArray = npt.NDArray[np.float64]


def packed_radius(world: WorldSpec) -> float:
    """Root mean square distance in m from their centroid of the world's robots when packed as tightly as discs can be."""
    return float(metrics.contact_radii(world).mean()) * math.sqrt(world.num_robots / (2 * HEXAGONAL_DENSITY))


@compiled()
def centroid(poses: FloatArray) -> tuple[float, float]:
    """Mean position in m of robots (R, 3)."""
    x, y = 0.0, 0.0
    for i in range(poses.shape[0]):
        x += poses[i, 0]
        y += poses[i, 1]
    return x / poses.shape[0], y / poses.shape[0]


@compiled()
def centroid_distances(poses: FloatArray) -> tuple[float, float]:
    """Mean distance in m of robots (R, 3) from their centroid, and its standard deviation."""
    x, y = centroid(poses)
    mean, square = 0.0, 0.0
    for i in range(poses.shape[0]):
        distance = math.hypot(poses[i, 0] - x, poses[i, 1] - y)
        mean += distance
        square += distance * distance
    mean /= poses.shape[0]
    return mean, math.sqrt(max(square / poses.shape[0] - mean * mean, 0.0))


@compiled()
def revolution(before: FloatArray, after: FloatArray, longest_step: float) -> float:
    """Share, from 0 to 1, of the longest way in a tick, ``longest_step`` in m, that robots (R, 3) went around their centroid."""
    x, y = centroid(after)
    x_before, y_before = centroid(before)
    x, y = 0.5 * (x + x_before), 0.5 * (y + y_before)
    total = 0.0
    for i in range(after.shape[0]):
        arm_x, arm_y = 0.5 * (after[i, 0] + before[i, 0]) - x, 0.5 * (after[i, 1] + before[i, 1]) - y
        distance = math.hypot(arm_x, arm_y)
        if distance > 0:
            total += (arm_x * (after[i, 1] - before[i, 1]) - arm_y * (after[i, 0] - before[i, 0])) / distance
    return float(min(1.0, abs(total) / (after.shape[0] * longest_step)))


@compiled()
def angular_evenness(poses: FloatArray) -> float:
    """1 when robots (R, 3) stand in even directions around their centroid, 0 when all stand in one."""
    robots = poses.shape[0]
    if robots < 2:
        return 1.0
    x, y = centroid(poses)
    angles = np.empty(robots)
    for i in range(robots):
        angles[i] = math.atan2(poses[i, 1] - y, poses[i, 0] - x)
    angles.sort()
    opening = angles[0] + 2 * math.pi - angles[robots - 1]
    for i in range(robots - 1):
        opening = max(opening, angles[i + 1] - angles[i])
    return float(min(1.0, max(0.0, 1.0 - opening / (2 * math.pi)) / (1.0 - 1.0 / robots)))


@compiled()
def share_off_walls(poses: FloatArray, edges: FloatArray, radii: FloatArray) -> float:
    """Share of robots (R, 3) whose contact disc is more than its radius away from every edge (E, 4)."""
    away = 0
    for i in range(poses.shape[0]):
        away += nearest_segment(poses[i, 0], poses[i, 1], edges)[0] > 2 * radii[i]
    return float(away / poses.shape[0])

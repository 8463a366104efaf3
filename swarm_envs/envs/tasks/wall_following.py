"""Wall following: robots drive along the wall, all in one sense."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from swarm_envs import metrics
from swarm_envs.compiled import compiled
from swarm_envs.simulation.segments import nearest_segment, polygon_edges
from swarm_envs.worlds import WorldSpec

FloatArray = npt.NDArray[np.float64]


def wall_following(world: WorldSpec) -> Callable[[FloatArray, FloatArray], FloatArray]:
    """Drive along the wall, all in one sense.

    |mean over robots of c u|, at most 1, with u the speed along the nearest piece of the arena's wall over the world's limit of linear
    speed, positive in one sense and negative in the other, and c = 1 / (1 + (g / R)^2) with g the gap between wall and contact disc and R
    the disc's radius.
    """
    longest_step = world.limits.linear_speed * world.tick
    edges, radii = polygon_edges(world.arena.outline), metrics.contact_radii(world)

    def rewards(before: FloatArray, after: FloatArray) -> FloatArray:
        return _rewards(before, after, longest_step, edges, radii)

    return rewards


@compiled()
def _rewards(before: FloatArray, after: FloatArray, longest_step: float, edges: FloatArray, radii: FloatArray) -> FloatArray:
    out = np.empty(after.shape[0])
    for w in range(after.shape[0]):
        total = 0.0
        for i in range(after.shape[1]):
            distance, k = nearest_segment(after[w, i, 0], after[w, i, 1], edges)
            gap = max(distance - radii[i], 0.0) / radii[i]
            wall_x, wall_y = edges[k, 2] - edges[k, 0], edges[k, 3] - edges[k, 1]
            way = (after[w, i, 0] - before[w, i, 0]) * wall_x + (after[w, i, 1] - before[w, i, 1]) * wall_y
            total += way / math.hypot(wall_x, wall_y) / (1.0 + gap * gap)
        out[w] = min(1.0, abs(total) / (after.shape[1] * longest_step))
    return out

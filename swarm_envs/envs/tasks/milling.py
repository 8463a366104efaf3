"""Milling: robots revolve around a common centre at every distance from it."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from swarm_envs import metrics
from swarm_envs.compiled import compiled
from swarm_envs.envs.tasks.swarm_shape import around_centroid, heap_radius, in_the_open, revolution
from swarm_envs.simulation.segments import polygon_edges
from swarm_envs.worlds import WorldSpec

FloatArray = npt.NDArray[np.float64]
FILLED = 1 / math.sqrt(8)
"""Standard deviation over mean of the distances to its centre of an evenly filled disc."""
LOOSE = 1.5
"""How many times wider than the tightest heap a mill is: its robots do not press on one another."""


def milling(world: WorldSpec) -> Callable[[FloatArray, FloatArray], FloatArray]:
    """Revolve around a common centre, near and far from it, away from the walls.

    The product of four shares from 0 to 1:

    - filled: (s / 0.354)^2, at most 1, with s the standard deviation over the mean of the robots' distances to their centroid, and 0.354
      that of an evenly filled disc: a ring has 0;
    - loose: d / (1.5 h), at most 1, with d the mean distance to the centroid and h the root mean square of that in the tightest heap;
    - revolution: the mean speed around the centroid in one sense, over the world's limit of linear speed;
    - open: the share of robots farther than a contact radius from the wall.
    """
    reach = world.limits.linear_speed * world.tick
    edges, radii, heap = polygon_edges(world.arena.outline), metrics.contact_radii(world), heap_radius(world)

    def rewards(before: FloatArray, after: FloatArray) -> FloatArray:
        return _rewards(before, after, reach, edges, radii, heap)

    return rewards


@compiled()
def _rewards(before: FloatArray, after: FloatArray, reach: float, edges: FloatArray, radii: FloatArray, heap: float) -> FloatArray:
    out = np.empty(after.shape[0])
    for w in range(after.shape[0]):
        mean, deviation = around_centroid(after[w])
        filled = min(1.0, deviation / max(mean, 1e-9) / FILLED)
        loose = min(1.0, mean / (LOOSE * heap))
        out[w] = filled * filled * loose * revolution(before[w], after[w], reach) * in_the_open(after[w], edges, radii)
    return out

"""Milling: robots revolve around a common centre at every distance from it."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from swarm_envs import metrics
from swarm_envs.compiled import compiled
from swarm_envs.envs.tasks.swarm_shape import centroid_distances, packed_radius, revolution, share_off_walls
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
    longest_step = world.limits.linear_speed * world.tick
    edges, radii, packed = polygon_edges(world.arena.outline), metrics.contact_radii(world), packed_radius(world)

    def rewards(before: FloatArray, after: FloatArray) -> FloatArray:
        return _rewards(before, after, longest_step, edges, radii, packed)

    return rewards


@compiled()
def _rewards(before: FloatArray, after: FloatArray, longest_step: float, edges: FloatArray, radii: FloatArray, packed: float) -> FloatArray:
    out = np.empty(after.shape[0])
    for w in range(after.shape[0]):
        mean, deviation = centroid_distances(after[w])
        filled = min(1.0, deviation / max(mean, 1e-9) / FILLED)
        loose = min(1.0, mean / (LOOSE * packed))
        out[w] = filled * filled * loose * revolution(before[w], after[w], longest_step) * share_off_walls(after[w], edges, radii)
    return out

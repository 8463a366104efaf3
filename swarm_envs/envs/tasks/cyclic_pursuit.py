"""Cyclic pursuit: robots drive behind one another on a circle."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from swarm_envs import metrics
from swarm_envs.compiled import compiled
from swarm_envs.envs.tasks.swarm_shape import angular_evenness, centroid_distances, revolution, share_off_walls
from swarm_envs.simulation.segments import polygon_edges
from swarm_envs.worlds import WorldSpec

FloatArray = npt.NDArray[np.float64]
ROUGHNESS = 0.2
"""Ratio of standard deviation to mean of the distances to the centroid at which the circle counts 1 / e."""


def cyclic_pursuit(world: WorldSpec) -> Callable[[FloatArray, FloatArray], FloatArray]:
    """Drive behind one another on a circle, away from the walls.

    The product of four shares from 0 to 1:

    - circle: exp(-(s / 0.2)^2), with s the standard deviation over the mean of the robots' distances to their centroid;
    - evenness: 1 when the robots' directions from the centroid are evenly spaced, 0 when all are one;
    - revolution: the mean speed around the centroid in one sense, over the world's limit of linear speed;
    - open: the share of robots farther than a contact radius from the wall.
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
        mean, deviation = centroid_distances(after[w])
        roughness = deviation / max(mean, 1e-9) / ROUGHNESS
        circle = math.exp(-roughness * roughness)
        out[w] = (
            circle * angular_evenness(after[w]) * revolution(before[w], after[w], longest_step) * share_off_walls(after[w], edges, radii)
        )
    return out

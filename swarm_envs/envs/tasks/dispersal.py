"""Dispersal: robots spread evenly over the floor."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import shapely

from swarm_envs import metrics
from swarm_envs.behaviours import HEXAGONAL_DISTANCE
from swarm_envs.compiled import compiled
from swarm_envs.worlds import WorldSpec

FloatArray = npt.NDArray[np.float64]
FLOOR_STEP = 0.1
"""Distance of the floor points that are looked at, over the square root of the arena's area."""


def dispersal(world: WorldSpec) -> Callable[[FloatArray, FloatArray], FloatArray]:
    """Spread evenly over the whole floor.

    The product of two shares from 0 to 1, both 1 where robots stand as a hexagonal lattice that fills the floor:

    - spacing: the mean over robots of the distance to the nearest other one, each counted up to the lattice's, over the lattice's;
    - cover: the lattice's mean distance from a floor point to the nearest robot over the swarm's own, at most 1.
    """
    radius, robots = float(metrics.contact_radii(world).mean()), world.num_robots
    reachable = max(float(shapely.area(metrics.floor_shape(world, radius))), radius**2)
    floor = float(shapely.area(metrics.floor_shape(world, 0.0)))
    lattice = math.sqrt(2 * reachable / (math.sqrt(3) * robots))
    emptiness = HEXAGONAL_DISTANCE * math.sqrt(floor / robots)
    points = metrics.floor_points(world, FLOOR_STEP * math.sqrt(floor))

    def rewards(before: FloatArray, after: FloatArray) -> FloatArray:
        return _rewards(after, points, lattice, emptiness)

    return rewards


@compiled()
def _rewards(after: FloatArray, points: FloatArray, lattice: float, emptiness: float) -> FloatArray:
    out, robots = np.empty(after.shape[0]), after.shape[1]
    for w in range(after.shape[0]):
        spacing = 0.0
        for i in range(robots):
            nearest = lattice * lattice
            for j in range(robots):
                if j != i:
                    nearest = min(nearest, (after[w, i, 0] - after[w, j, 0]) ** 2 + (after[w, i, 1] - after[w, j, 1]) ** 2)
            spacing += math.sqrt(nearest)
        distance = 0.0
        for k in range(points.shape[0]):
            nearest = math.inf
            for i in range(robots):
                nearest = min(nearest, (after[w, i, 0] - points[k, 0]) ** 2 + (after[w, i, 1] - points[k, 1]) ** 2)
            distance += math.sqrt(nearest)
        out[w] = spacing / (robots * lattice) * min(1.0, emptiness * points.shape[0] / distance)
    return out

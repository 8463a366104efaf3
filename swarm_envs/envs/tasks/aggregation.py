"""Aggregation: all robots in one tight heap."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from swarm_envs.compiled import compiled
from swarm_envs.envs.tasks.swarm_shape import centroid, packed_radius
from swarm_envs.worlds import WorldSpec

FloatArray = npt.NDArray[np.float64]


def aggregation(world: WorldSpec) -> Callable[[FloatArray, FloatArray], FloatArray]:
    """Gather in one heap.

    min(1, h / d), with d the root mean square distance of the robots from their centroid and h that of as many discs packed as tightly
    as discs can be. 1 is a perfect heap; eight robots of `hero_plus` at the start have about 0.3.
    """
    packed = packed_radius(world)

    def rewards(before: FloatArray, after: FloatArray) -> FloatArray:
        return _rewards(after, packed)

    return rewards


@compiled()
def _rewards(after: FloatArray, packed: float) -> FloatArray:
    out = np.empty(after.shape[0])
    for w in range(after.shape[0]):
        x, y = centroid(after[w])
        square = 0.0
        for i in range(after.shape[1]):
            square += (after[w, i, 0] - x) ** 2 + (after[w, i, 1] - y) ** 2
        spread = math.sqrt(square / after.shape[1])
        out[w] = packed / max(spread, packed)
    return out

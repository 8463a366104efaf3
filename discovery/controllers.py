"""Controllers [v0, w0, v1, w1]: their box, random ones, and a check of given ones."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from discovery.errors import DiscoveryError
from swarm_envs.worlds import WorldSpec

FloatArray = npt.NDArray[np.float64]

GENES = ("v0", "w0", "v1", "w1")
"""Forward speed in m/s and turn rate in rad/s when nothing is detected (0) and when something is (1)."""


def gene_limits(world: WorldSpec) -> FloatArray:
    """Return the largest magnitude (4,) of each gene, in m/s and rad/s."""
    return np.array([world.limits.linear_speed, world.limits.angular_speed] * 2)


def random_controllers(world: WorldSpec, count: int, rng: np.random.Generator) -> FloatArray:
    """Draw controllers (count, 4) uniformly within the world's limits."""
    limits = gene_limits(world)
    return rng.uniform(-limits, limits, (count, 4))


def check_controllers(world: WorldSpec, controllers: Sequence[Any]) -> FloatArray:
    """Return given controllers as an array (count, 4).

    Raises:
        DiscoveryError: When one has not four finite numbers within the world's limits.
    """
    limits = gene_limits(world)
    for controller in controllers:
        if not isinstance(controller, Sequence) or len(controller) != 4 or not all(isinstance(gene, int | float) for gene in controller):
            raise DiscoveryError(f"search.include: given {controller}, expected four numbers [v0, w0, v1, w1] in m/s and rad/s")
        for gene, value, limit in zip(GENES, controller, limits, strict=True):
            if not abs(value) <= limit:  # NaN fails too
                raise DiscoveryError(
                    f"search.include: {gene} is {value:g}, expected at most {limit:g} {'m/s' if gene[0] == 'v' else 'rad/s'} "
                    f"in magnitude, the limit of world {world.name}"
                )
    return np.array(controllers, dtype=np.float64).reshape(-1, 4)

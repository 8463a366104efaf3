"""Which controllers may be proposed: a box of genes, with room cut out around standing still and driving straight."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from discovery.controllers import GENES, FloatArray, gene_limits
from discovery.errors import DiscoveryError
from discovery.settings import SearchSettings
from swarm_envs.worlds import WorldSpec


@dataclass(frozen=True)
class GeneBox:
    """Magnitudes that genes may have."""

    limits: FloatArray
    """(4,) largest, in m/s and rad/s."""
    minimum: FloatArray
    """(4,) smallest, in m/s and rad/s; the authors' simulator takes 0.05 and 0.4."""

    def draw(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Draw controllers (count, 4) uniformly from what may be proposed."""
        drawn = rng.uniform(-self.limits, self.limits, (count, len(self.limits)))
        if not self.minimum.any():
            return drawn
        # magnitudes uniform from minimum to limit, as if draws in between had been thrown away
        magnitudes = self.minimum + np.abs(drawn) * (1 - self.minimum / self.limits)
        return np.copysign(np.minimum(magnitudes, self.limits), drawn)

    def accepts(self, controllers: FloatArray) -> npt.NDArray[np.bool_]:
        """Whether each of controllers (N, 4) may be proposed, (N,)."""
        magnitudes = np.abs(controllers)
        return np.asarray(((magnitudes >= self.minimum) & (magnitudes <= self.limits)).all(axis=1))


def gene_box(world: WorldSpec, settings: SearchSettings, include: FloatArray) -> GeneBox:
    """Return the box that a world and the settings leave.

    Args:
        world: Its limits.
        settings: ``min_speed`` and ``min_turn_rate``.
        include: (n, 4) controllers that the first population is to hold.

    Raises:
        DiscoveryError: When nothing is left of it, or one of ``include`` lies outside.
    """
    box = GeneBox(gene_limits(world), np.array([settings.min_speed, settings.min_turn_rate] * 2))
    for name, gene, unit in (("min_speed", 0, "m/s"), ("min_turn_rate", 1, "rad/s")):
        if not box.minimum[gene] < box.limits[gene]:
            raise DiscoveryError(
                f"search.{name}: given {box.minimum[gene]:g}, expected less than {box.limits[gene]:g} {unit}, "
                f"the limit of world {world.name}"
            )
    for controller in include[~box.accepts(include)]:
        names = ", ".join(GENES)
        raise DiscoveryError(
            f"search.include: given {controller.tolist()} as [{names}], slower than search.min_speed or search.min_turn_rate allow"
        )
    return box

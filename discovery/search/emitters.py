"""Who proposes controllers: pyribs emitters, one for each ``search.method``.

A new one is any emitter of pyribs or a subclass of its ``EmitterBase``, a function here that makes it, a line in :data:`EMITTERS` and a
file in ``configs/search``. Its ``ask`` returns (population, 4) controllers; its ``tell`` gets their embeddings as ``measures``, what the
archive says as ``add_info``, and labels and metrics as fields. Whatever it draws must follow from the seed and from what it was told: a
stopped search resumes by telling it everything again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from ribs.archives import ArchiveBase
from ribs.emitters import EmitterBase, IsoLineEmitter

from discovery.controllers import FloatArray
from discovery.errors import DiscoveryError
from discovery.randomness import generator, whole_seed
from discovery.search.gene_box import GeneBox
from discovery.search.genetic_emitter import GeneticEmitter
from discovery.settings import SearchSettings

TRIES = 1000
"""How often an emitter is asked again for controllers that may be proposed."""


@dataclass(frozen=True)
class EmitterContext:
    """What an emitter is made from."""

    archive: ArchiveBase
    """Where parents come from."""
    box: GeneBox
    """What may be proposed."""
    settings: SearchSettings
    seed: int
    """The run's."""
    include: FloatArray
    """(n, 4) controllers that its first population begins with."""
    begin: int = 0
    """Generation that it begins with."""


class RandomEmitter(EmitterBase):
    """Proposes controllers drawn uniformly, each population from (seed, generation)."""

    def __init__(self, context: EmitterContext) -> None:
        super().__init__(context.archive, solution_dim=4, bounds=None, lower_bounds=-context.box.limits, upper_bounds=context.box.limits)
        self._context = context
        self.generation = context.begin
        """The generation that :meth:`ask` makes next."""

    def ask(self) -> FloatArray:
        """Return (population, 4) controllers."""
        size = self._context.settings.population
        drawn = self._context.box.draw(size, generator(self._context.seed, "search", self.generation))
        return np.concatenate([self._context.include, drawn])[:size] if self.generation == 0 else drawn

    def tell(self, solution: npt.ArrayLike, objective: Any, measures: npt.ArrayLike, add_info: Any, **fields: Any) -> None:
        """Go to the next generation; what became of this one changes nothing."""
        self.generation += 1


class RejectionEmitter(EmitterBase):
    """Asks another emitter until it has a population of controllers that may be proposed; the others are never evaluated."""

    def __init__(self, emitter: EmitterBase, box: GeneBox, population: int) -> None:
        super().__init__(emitter.archive, solution_dim=4, bounds=None, lower_bounds=-box.limits, upper_bounds=box.limits)
        self._emitter, self._box, self._population = emitter, box, population

    def ask(self) -> FloatArray:
        """Return (population, 4) controllers.

        Raises:
            DiscoveryError: When the other emitter hardly ever proposes what may be proposed.
        """
        kept: list[FloatArray] = []
        for _ in range(TRIES):
            asked = self._emitter.ask()
            kept.append(asked[self._box.accepts(asked)])
            if sum(map(len, kept)) >= self._population:
                return np.concatenate(kept)[: self._population]
        raise DiscoveryError("search.min_speed, search.min_turn_rate: hardly any proposed controller has them; ask for less")

    def tell(self, *given: Any, **fields: Any) -> None:
        """Pass on what became of the population."""
        self._emitter.tell(*given, **fields)


def _genetic(context: EmitterContext) -> EmitterBase:
    return GeneticEmitter(context.archive, context.box, context.settings, context.seed, context.include)


def _isoline(context: EmitterContext) -> EmitterBase:
    return IsoLineEmitter(
        context.archive,
        iso_sigma=context.settings.iso_sigma * context.box.limits,  # type: ignore[arg-type]  # a number for each gene broadcasts
        line_sigma=context.settings.line_sigma,
        x0=np.zeros(4),  # never used: the warm-up fills the archive
        lower_bounds=-context.box.limits,
        upper_bounds=context.box.limits,
        batch_size=context.settings.population,
        seed=whole_seed(context.seed, "emitter"),
    )


EMITTERS: dict[str, Callable[[EmitterContext], EmitterBase]] = {"novelty": _genetic, "random": RandomEmitter, "isoline": _isoline}
"""How the emitter of each ``search.method`` is made."""


def make_emitter(method: str, context: EmitterContext) -> EmitterBase:
    """Return the emitter of a method."""
    emitter = EMITTERS[method](context)
    return RejectionEmitter(emitter, context.box, context.settings.population) if context.box.minimum.any() else emitter

"""The genetic algorithm as a pyribs emitter: tournaments for novelty, crossover, mutation (paper, Behavior Discovery)."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from ribs.archives import ArchiveBase
from ribs.emitters import EmitterBase

from discovery.controllers import FloatArray
from discovery.randomness import generator
from discovery.search.gene_box import GeneBox
from discovery.settings import SearchSettings

REDRAWS = 1000
"""How often a change is drawn again; what is wrong even then is not proposed."""


class GeneticEmitter(EmitterBase):
    """Asks for a random population first, then for the children of the last one.

    Every draw comes from (seed, generation), so that telling the same results again leads to the same state: a stopped search
    resumes by replay.

    Args:
        archive: Says how novel what it is given is: ``add_info["novelty"]``.
        box: What may be proposed.
        settings: Population, rates and sizes.
        seed: The run's seed.
        include: (n, 4) controllers that take the first places of the first population.
    """

    def __init__(self, archive: ArchiveBase, box: GeneBox, settings: SearchSettings, seed: int, include: FloatArray) -> None:
        super().__init__(archive, solution_dim=len(box.limits), bounds=None, lower_bounds=-box.limits, upper_bounds=box.limits)
        self._box = box
        self._settings = settings
        self._seed = seed
        self._include = include
        self.generation = 0
        """The generation that :meth:`ask` makes next."""
        self._asked = 0
        self._parents: FloatArray = np.empty((0, len(box.limits)))
        self._novelty: FloatArray = np.empty(0)

    def ask(self) -> FloatArray:
        """Return the next population, (population, 4); asked again, another one."""
        again = (self._asked,) if self._asked else ()
        self._asked += 1
        rng, size = generator(self._seed, "search", self.generation, *again), self._settings.population
        if self.generation == 0:
            return np.concatenate([self._include, self._box.draw(size, rng)])[:size]
        return children(self._parents, self._novelty, size, self._box, self._settings, rng)

    def tell(self, solution: npt.ArrayLike, objective: Any, measures: npt.ArrayLike, add_info: Any, **fields: Any) -> None:
        """Take what became of the population: ``add_info["novelty"]`` selects, ``fields["metrics"]`` may bar from it."""
        self._parents = np.asarray(solution, dtype=np.float64)
        self._novelty = np.asarray(add_info["novelty"], dtype=np.float64)
        if self._settings.minimal_criterion > 0:
            fast = np.asarray(fields["metrics"])[:, 0] >= self._settings.minimal_criterion * self._box.limits[0]
            if fast.sum() > 1:  # else nobody is left to choose from: all may be parents
                self._parents, self._novelty = self._parents[fast], self._novelty[fast]
        self.generation += 1
        self._asked = 0


def children(
    parents: FloatArray, fitness: FloatArray, count: int, box: GeneBox, settings: SearchSettings, rng: np.random.Generator
) -> FloatArray:
    """Breed a new population.

    Args:
        parents: (n, genes).
        fitness: (n,), the greater the better.
        count: How many children.
        box: What may be proposed.
        settings: Tournament size and rates.
        rng: Source of every draw.
    """
    mothers, fathers = (tournament(fitness, count, settings.tournament, rng) for _ in range(2))
    first, second = parents[mothers], parents[fathers]
    return mutate(cross(first, second, settings.crossover, rng), box, settings.mutation, settings.mutation_step, rng)


def tournament(fitness: FloatArray, winners: int, contestants: int, rng: np.random.Generator) -> npt.NDArray[np.int64]:
    """Return the indices (winners,) of the best of ``contestants`` distinct members (all, when there are fewer), drawn again each time."""
    size = min(contestants, len(fitness))
    rivals: npt.NDArray[np.int64] = np.argsort(rng.random((winners, len(fitness))), axis=1)[:, :size]
    best = np.argmax(fitness[rivals], axis=1, keepdims=True)
    return np.take_along_axis(rivals, best, axis=1)[:, 0]


def cross(first: FloatArray, second: FloatArray, rate: float, rng: np.random.Generator) -> FloatArray:
    """One-point crossover: with probability ``rate`` a child takes the genes from a random point on from its second parent."""
    count, genes = first.shape
    point = rng.integers(1, genes, size=count)
    crossed = rng.random(count) < rate
    after_point = np.arange(genes)[None, :] >= np.reshape(point, (-1, 1))
    return np.where(after_point & np.reshape(crossed, (-1, 1)), second, first)


def mutate(population: FloatArray, box: GeneBox, rate: float, step: float, rng: np.random.Generator) -> FloatArray:
    """With probability ``rate`` add to a gene a normal change of standard deviation ``step`` times its limit.

    What leaves the limits is reflected back: clipping would pile controllers up at full speed. A change to what may not be proposed is
    drawn again: rejecting the whole child would favour copies of its parents.
    """
    change = rng.normal(0.0, step * box.limits, population.shape)
    changed = rng.random(population.shape) < rate
    mutated = reflect(np.where(changed, population + change, population), box.limits)
    for _ in range(REDRAWS if box.minimum.any() else 0):
        wrong = changed & (np.abs(mutated) < box.minimum)
        if not wrong.any():
            break
        change = rng.normal(0.0, step * box.limits, population.shape)
        mutated = np.where(wrong, reflect(population + change, box.limits), mutated)
    return mutated


def reflect(values: FloatArray, limits: FloatArray) -> FloatArray:
    """Fold values into [-limits, limits] as a mirror at each end does; values inside stay as they are, to the last bit."""
    folded = limits - np.abs((values + limits) % (4 * limits) - 2 * limits)
    return np.where(np.abs(values) <= limits, values, np.clip(folded, -limits, limits))

"""The genetic algorithm as a pyribs emitter: tournaments for novelty, crossover, mutation (paper, Behavior Discovery)."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from ribs.archives import ProximityArchive
from ribs.emitters import EmitterBase

from discovery.controllers import FloatArray
from discovery.novelty import novelty
from discovery.randomness import generator
from discovery.settings import SearchSettings


class GeneticEmitter(EmitterBase):
    """Asks for a random population first, then for the children of the last one.

    Every draw comes from (seed, generation), so that telling the same results again leads to the same state: a stopped search
    resumes by replay.

    Args:
        archive: Keeps everything; novelty is measured against it.
        limits: (4,) largest magnitude of each gene.
        settings: Population, rates and sizes.
        seed: The run's seed.
        include: (n, 4) controllers that take the first places of the first population.
    """

    def __init__(self, archive: ProximityArchive, limits: FloatArray, settings: SearchSettings, seed: int, include: FloatArray) -> None:
        super().__init__(archive, solution_dim=len(limits), bounds=None, lower_bounds=-limits, upper_bounds=limits)
        self._settings = settings
        self._seed = seed
        self._include = include
        self._neighbours = int(archive.k_neighbors)
        self.generation = 0
        """The generation that :meth:`ask` makes next."""
        self.novelty: FloatArray = np.empty(0)
        """(population,) novelty of the generation told last, its own members left out one at a time."""
        self._parents: FloatArray = np.empty((0, len(limits)))

    def ask(self) -> FloatArray:
        """Return the next population, (population, 4)."""
        rng, size = generator(self._seed, "search", self.generation), self._settings.population
        if self.generation == 0:
            drawn = rng.uniform(self.lower_bounds, self.upper_bounds, (size, len(self.lower_bounds)))
            return np.concatenate([self._include, drawn])[:size]
        return children(self._parents, self.novelty, self.upper_bounds, self._settings, rng)

    def tell(self, solution: npt.ArrayLike, objective: Any, measures: npt.ArrayLike, add_info: Any, **fields: Any) -> None:
        """Take the population's embeddings; the archive holds them already."""
        self._parents = np.asarray(solution, dtype=np.float64)
        self.novelty = novelty(np.asarray(measures), np.asarray(self.archive.data("measures")), self._neighbours)
        self.generation += 1


def children(
    parents: FloatArray, fitness: FloatArray, limits: FloatArray, settings: SearchSettings, rng: np.random.Generator
) -> FloatArray:
    """Breed a new population of the same size.

    Args:
        parents: (population, genes).
        fitness: (population,), the greater the better.
        limits: (genes,) largest magnitude of each gene.
        settings: Tournament size and rates.
        rng: Source of every draw.
    """
    mothers, fathers = (tournament(fitness, len(parents), settings.tournament, rng) for _ in range(2))
    first, second = parents[mothers], parents[fathers]
    return mutate(cross(first, second, settings.crossover, rng), limits, settings.mutation, settings.mutation_step, rng)


def tournament(fitness: FloatArray, winners: int, contestants: int, rng: np.random.Generator) -> npt.NDArray[np.int64]:
    """Return the indices (winners,) of the best of ``contestants`` distinct members (all, when there are fewer), each time anew."""
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


def mutate(population: FloatArray, limits: FloatArray, rate: float, step: float, rng: np.random.Generator) -> FloatArray:
    """With probability ``rate`` add to a gene a normal change of standard deviation ``step`` times its limit.

    What leaves the limits is reflected back: clipping would pile controllers up at full speed.
    """
    change = rng.normal(0.0, step * limits, population.shape)
    mutated = np.where(rng.random(population.shape) < rate, population + change, population)
    return reflect(mutated, limits)


def reflect(values: FloatArray, limits: FloatArray) -> FloatArray:
    """Fold values into [-limits, limits] as a mirror at each end does; values inside stay as they are, to the last bit."""
    folded = limits - np.abs((values + limits) % (4 * limits) - 2 * limits)
    return np.where(np.abs(values) <= limits, values, np.clip(folded, -limits, limits))

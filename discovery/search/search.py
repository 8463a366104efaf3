"""The search: pyribs' scheduler, a record of everything evaluated, and one saved part per generation."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import numpy.typing as npt
from ribs.archives import ArchiveBase, CVTArchive, k_means_centroids
from ribs.schedulers import Scheduler
from threadpoolctl import threadpool_limits

from discovery.controllers import FloatArray, check_controllers
from discovery.errors import DiscoveryError
from discovery.progress import bar
from discovery.randomness import whole_seed
from discovery.representations.interface import Representation
from discovery.rollouts.labels import BEHAVIOURS, LABEL_BYTES, decode_labels, encode_labels
from discovery.rollouts.simulator import Simulator
from discovery.runs.archive import Archive
from discovery.runs.run_folder import RunFolder, part_name
from discovery.search.emitters import EmitterContext, make_emitter
from discovery.search.gene_box import gene_box
from discovery.search.unstructured_archive import UnstructuredArchive
from discovery.settings import SearchSettings
from swarm_envs.behaviours import label
from swarm_envs.metrics import hand_crafted
from swarm_envs.worlds import WorldSpec

FIELDS: dict[str, Any] = {
    "generation": ((), np.int64),
    "world_seed": ((), np.int64),
    "world_index": ((), np.int64),
    "label": ((LABEL_BYTES,), np.uint8),
    "metrics": ((5,), np.float64),
}
"""What archives keep beside controller and embedding."""


class BehaviourSearch:
    """A search in progress; it evaluates nothing itself.

    Args:
        settings: The search's.
        world: For the controllers' limits.
        dimension: Numbers in an embedding.
        seed: The run's.
    """

    def __init__(self, settings: SearchSettings, world: WorldSpec, dimension: int, seed: int) -> None:
        self._settings, self._seed = settings, seed
        self._include = check_controllers(world, settings.include)
        self._box = gene_box(world, settings, self._include)
        self.record = UnstructuredArchive(
            solution_dim=4,
            measure_dim=dimension,
            k_neighbors=settings.neighbours,
            distance=settings.distance,
            initial_capacity=settings.population * settings.generations,
            extra_fields=FIELDS,
            seed=whole_seed(seed, "archive"),
        )
        """Everything evaluated, in order, wherever parents come from."""
        self.generation = 0
        """How many generations were told."""
        self._labels: Counter[str] = Counter()
        self._parents: ArchiveBase = self.record
        self._scheduler = self._schedule("random" if settings.warmup else settings.method, self._include)

    def ask(self) -> FloatArray:
        """Return the next controllers to evaluate, (population, 4)."""
        return np.asarray(self._scheduler.ask())

    def tell(self, seed: int, tensors: dict[str, npt.NDArray[Any]]) -> None:
        """Take what :func:`evaluate` found of them, with the seed of their starts."""
        count = len(tensors["embeddings"])
        self._scheduler.tell(
            objective=np.full(count, float(self.generation)),  # nothing is better than another thing: a cell keeps the latest
            measures=tensors["embeddings"],
            generation=np.full(count, self.generation),
            world_seed=np.full(count, seed),
            world_index=np.arange(count),
            label=tensors["labels"],
            metrics=tensors["metrics"],
        )
        self._labels.update(decode_labels(tensors["labels"]))
        self.generation += 1
        if self.generation == self._settings.warmup:
            self._parents = self._tessellate() if self._settings.archive == "cvt" else self.record
            self._scheduler = self._schedule(self._settings.method, self._include[:0])

    def members(self) -> npt.NDArray[np.int64]:
        """Return the rows (M,) of :meth:`archive` that parents come from, in order."""
        held = self._parents.data(["generation", "world_index"])
        return np.sort(held["generation"] * self._settings.population + held["world_index"])

    def numbers(self) -> dict[str, float]:
        """Return what a tracker shows of the last generation, and how many of each label there are in all."""
        novelty = self.record.data("novelty")[-self._settings.population :]
        counts = {f"labels/{name}": float(self._labels[name]) for name in BEHAVIOURS}
        return {"novelty/mean": float(novelty.mean()), "novelty/max": float(novelty.max()), **counts}

    def archive(self) -> Archive:
        """Return everything evaluated so far."""
        data = self.record.data()
        return Archive(
            controllers=data["solution"],
            embeddings=data["measures"],
            generation=data["generation"],
            novelty=data["novelty"],
            world_seed=data["world_seed"],
            world_index=data["world_index"],
            labels=np.array(decode_labels(data["label"]), dtype=np.str_),
            metrics=data["metrics"],
        )

    def _schedule(self, method: str, include: FloatArray) -> Scheduler:
        parents, begin = self._parents, self.generation if method == "random" else 0
        emitter = make_emitter(method, EmitterContext(parents, self._box, self._settings, self._seed, include, begin))
        return Scheduler(parents, [emitter], result_archive=None if parents is self.record else self.record)

    def _tessellate(self) -> CVTArchive:
        """Return an archive with cells round what the warm-up has found, and that in them.

        Cells in the whole space of embeddings, as pyribs makes them by itself, would nearly all stay empty in 512 dimensions.
        """
        found = self.record.data()
        embeddings, seed = found["measures"], whole_seed(self._seed, "cells")
        ranges = np.stack([embeddings.min(axis=0), embeddings.max(axis=0)], axis=1)
        with threadpool_limits(1):  # sums in the same order on any machine
            centres, _ = k_means_centroids(centroids=self._settings.cells, ranges=ranges, samples=embeddings, dtype=np.float32, seed=seed)
            cells = CVTArchive(
                solution_dim=4, centroids=centres, ranges=ranges, measures_dtype=np.float32, extra_fields=FIELDS,
                seed=whole_seed(self._seed, "archive"),
            )  # fmt: skip
        cells.add(found["solution"], found["generation"].astype(np.float64), embeddings, **{name: found[name] for name in FIELDS})
        return cells


def run_search(folder: RunFolder, simulator: Simulator, representation: Representation) -> tuple[Archive, npt.NDArray[np.int64]]:
    """Evaluate every generation that the folder does not hold yet.

    Returns:
        Everything evaluated, and its rows (M,) that the search's archive holds in the end.
    """
    settings = folder.settings.search
    search = BehaviourSearch(settings, simulator.world, representation.dimension, folder.settings.seed)
    replay = folder.parts("search")
    folder.tracker.begin("search")
    with bar(settings.population * settings.generations, "search", "rollouts") as progress:
        for number in range(settings.generations):
            controllers, seed = search.ask(), whole_seed(folder.settings.seed, "search starts", number)
            part = next(replay, None)
            if part is None:
                tensors = evaluate(simulator, representation, controllers, seed)
                folder.write_tensors(part_name("search", number), {"controllers": controllers, **tensors}, {})
            else:
                tensors = part.tensors
                if not np.array_equal(tensors["controllers"], controllers):
                    raise DiscoveryError(
                        f"{folder.path / part_name('search', number)}: does not follow from the generation before it (another version?); "
                        "delete the search folder beside it to search again"
                    )
            search.tell(seed, tensors)
            folder.tracker.log("search", number, search.numbers())
            folder.tracker.flush()
            progress.update(settings.population)
    return search.archive(), search.members()


def evaluate(simulator: Simulator, representation: Representation, controllers: FloatArray, seed: int) -> dict[str, npt.NDArray[Any]]:
    """Roll out, embed, label and measure a population; arrays by name, each (population, ...)."""
    trajectories = simulator(controllers, seed)
    return {
        "embeddings": representation.embed(trajectories),
        "labels": encode_labels(label(trajectories)),
        "metrics": hand_crafted(trajectories),
    }

"""Novelty search: pyribs' scheduler, an archive that keeps everything, and one saved part a generation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from ribs.archives import ProximityArchive
from ribs.schedulers import Scheduler

from discovery.archive import Archive
from discovery.controllers import FloatArray, check_controllers, gene_limits
from discovery.errors import DiscoveryError
from discovery.genetic_emitter import GeneticEmitter
from discovery.labels import LABEL_BYTES, decode_labels, encode_labels
from discovery.progress import bar
from discovery.randomness import whole_seed
from discovery.representations.interface import Representation
from discovery.run_folder import RunFolder, part_name
from discovery.simulate import Simulator
from swarm_envs.behaviours import label
from swarm_envs.metrics import hand_crafted

FIELDS: dict[str, Any] = {
    "generation": ((), np.int64),
    "world_seed": ((), np.int64),
    "world_index": ((), np.int64),
    "label": ((LABEL_BYTES,), np.uint8),
    "metrics": ((5,), np.float64),
}
"""What the archive keeps beside controller and embedding."""


@dataclass(frozen=True)
class Search:
    """A search in progress."""

    archive: ProximityArchive
    emitter: GeneticEmitter
    scheduler: Scheduler


def begin_search(folder: RunFolder, simulator: Simulator, dimension: int) -> Search:
    """Return a search that has evaluated nothing."""
    settings = folder.settings.search
    archive = ProximityArchive(
        solution_dim=4,
        measure_dim=dimension,
        k_neighbors=settings.neighbours,
        novelty_threshold=0.0,  # every distance is at least this: everything evaluated stays, twins too
        initial_capacity=settings.population * settings.generations,
        measures_dtype=np.float32,
        extra_fields=FIELDS,
    )
    include = check_controllers(simulator.world, settings.include)
    emitter = GeneticEmitter(archive, gene_limits(simulator.world), settings, folder.settings.seed, include)
    return Search(archive, emitter, Scheduler(archive, [emitter]))


def run_search(folder: RunFolder, simulator: Simulator, representation: Representation) -> Archive:
    """Evaluate every generation that the folder does not hold yet, and return the archive."""
    settings = folder.settings.search
    search = begin_search(folder, simulator, representation.dimension)
    found: list[FloatArray] = []
    replay = folder.parts("search")
    with bar(settings.population * settings.generations, "search", "rollouts") as progress:
        for number in range(settings.generations):
            controllers = search.scheduler.ask()
            part = next(replay, None)
            if part is None:
                tensors = evaluate(simulator, representation, controllers, whole_seed(folder.settings.seed, "search starts", number))
                folder.write_tensors(part_name("search", number), {"controllers": controllers, **tensors}, {})
            else:
                tensors = part.tensors
                if not np.array_equal(tensors["controllers"], controllers):
                    raise DiscoveryError(
                        f"{folder.path / part_name('search', number)}: does not follow from the generation before it (another version?); "
                        "delete the search folder beside it to search again"
                    )
            tell(search, number, whole_seed(folder.settings.seed, "search starts", number), tensors)
            found.append(search.emitter.novelty)
            progress.update(settings.population)
    return _collect(search.archive, np.concatenate(found))


def evaluate(simulator: Simulator, representation: Representation, controllers: FloatArray, seed: int) -> dict[str, npt.NDArray[Any]]:
    """Roll out, embed, label and measure a population; arrays by name, each (population, ...)."""
    trajectories = simulator(controllers, seed)
    return {
        "embeddings": representation.embed(trajectories),
        "labels": encode_labels(label(trajectories)),
        "metrics": hand_crafted(trajectories),
    }


def tell(search: Search, generation: int, seed: int, tensors: dict[str, npt.NDArray[Any]]) -> None:
    """Give the scheduler one generation's results."""
    count = len(tensors["embeddings"])
    search.scheduler.tell(
        objective=None,
        measures=tensors["embeddings"],
        generation=np.full(count, generation),
        world_seed=np.full(count, seed),
        world_index=np.arange(count),
        label=tensors["labels"],
        metrics=tensors["metrics"],
    )


def _collect(archive: ProximityArchive, found: FloatArray) -> Archive:
    data = archive.data()
    return Archive(
        controllers=data["solution"],
        embeddings=data["measures"],
        generation=data["generation"],
        novelty=found,
        world_seed=data["world_seed"],
        world_index=data["world_index"],
        labels=np.array(decode_labels(data["label"]), dtype=np.str_),
        metrics=data["metrics"],
    )

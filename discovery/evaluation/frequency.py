"""Table 1 of the paper: which behaviours the medoids are, by representation, and what simpler ways would have found."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from discovery.controllers import random_controllers
from discovery.evaluation.groups import mean_and_error
from discovery.evaluation.tables import write_csv, write_figure, write_json
from discovery.labels import BEHAVIOURS
from discovery.medoids import cluster
from discovery.randomness import generator, whole_seed
from discovery.saved_run import Run
from discovery.simulate import Simulator
from swarm_envs.behaviours import label

RANDOM = "random"
"""Label of what is no behaviour."""
CHUNK = 250


@dataclass(frozen=True)
class Found:
    """What one way of choosing found, run by run."""

    name: str
    labels: list[list[str]]
    """Of each run's medoids, given by rules."""

    def count(self, behaviour: str) -> list[int]:
        """Medoids of a behaviour in each run."""
        return [labels.count(behaviour) for labels in self.labels]

    @property
    def unique(self) -> list[int]:
        """Different behaviours in each run, random not counted."""
        return [len(set(labels) - {RANDOM}) for labels in self.labels]


def medoids_found(name: str, runs: list[Run]) -> Found:
    """Return the labels of the runs' own medoids."""
    return Found(name, [[medoid.label for medoid in run.medoids] for run in runs])


def standardised_medoids(name: str, runs: list[Run]) -> Found:
    """Return what the medoids would be of embeddings that are standardised first."""
    labels = []
    for run in runs:
        scale = run.embeddings.std(axis=0)
        standard = (run.embeddings - run.embeddings.mean(axis=0)) / np.where(scale > 0.0, scale, 1.0)
        labels.append(_labels_of_medoids(standard, run.archive.labels, run))
    return Found(f"{name}; medoids of standardised embeddings", labels)


def random_search(name: str, runs: list[Run], simulator: Simulator) -> Found:
    """Return what random controllers, as many as the search evaluated, would have given instead of the search."""
    labels = []
    for run in runs:
        embeddings, names = [], []
        for number, begin in enumerate(range(0, len(run.archive), CHUNK)):
            count = min(CHUNK, len(run.archive) - begin)
            draws = generator(run.settings.seed, "random search", number)
            trajectories = simulator(
                random_controllers(simulator.world, count, draws), whole_seed(run.settings.seed, "random starts", number)
            )
            embeddings.append(run.representation.embed(trajectories))
            names += label(trajectories)
        labels.append(_labels_of_medoids(np.concatenate(embeddings), np.array(names), run))
    return Found(f"{name}; random sampling instead of search", labels)


def _labels_of_medoids(embeddings: npt.NDArray[Any], labels: npt.NDArray[np.str_], run: Run) -> list[str]:
    return list(labels[cluster(embeddings, run.settings.clustering, run.settings.seed).medoids].tolist())


def write_frequency(folder: Path, found: list[Found]) -> None:
    """Write ``behaviours.csv``, ``.json``, ``.png`` and ``.svg``."""
    head = ["way", "runs", "behaviour", "mean", "standard error"]
    rows: list[list[Any]] = []
    for entry in found:
        for name, counts in [*((name, entry.count(name)) for name in BEHAVIOURS), ("unique, random not counted", entry.unique)]:
            mean, error = mean_and_error(counts)
            rows.append([entry.name, len(entry.labels), name, float(mean), float(error)])
    write_csv(folder / "behaviours.csv", head, rows)
    write_json(
        folder / "behaviours.json",
        {
            "labels_given_by": "rules",
            "rows": [dict(zip([key.replace(" ", "_") for key in head], row, strict=True)) for row in rows],
            "medoids": {entry.name: [dict(Counter(labels)) for labels in entry.labels] for entry in found},
        },
    )
    write_figure(draw(found), folder / "behaviours")


def draw(found: list[Found]) -> Any:
    """Return a figure of stacked mean counts, a bar for each way."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 0.7 * len(found) + 1.6), layout="constrained")
    axis = figure.subplots()
    left = np.zeros(len(found))
    names = [f"{entry.name} ({len(entry.labels)})" for entry in found]
    for name in BEHAVIOURS:
        means = np.array([np.mean(entry.count(name)) for entry in found])
        axis.barh(names, means, left=left, label=name)
        left += means
    axis.invert_yaxis()
    axis.set_xlabel("medoids, mean over runs")
    axis.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.4, -0.25), ncols=6)
    return figure

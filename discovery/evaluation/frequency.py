"""Table 1 of the paper: which behaviours the medoids are, by representation, and what simpler ways would have found."""

from __future__ import annotations

import dataclasses
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from discovery.clustering.medoids import cluster
from discovery.controllers import random_controllers
from discovery.evaluation import published
from discovery.evaluation.groups import mean_and_error
from discovery.evaluation.legend import COLOURS
from discovery.evaluation.tables import RULES, write_csv, write_figure, write_json
from discovery.progress import bar
from discovery.randomness import generator, whole_seed
from discovery.rollouts.labels import BEHAVIOURS
from discovery.rollouts.simulator import Simulator
from discovery.saved_run import Run
from discovery.settings import ClusteringSettings
from swarm_envs.behaviours import label

RANDOM = "random"
"""Label of what is no behaviour."""
UNIQUE = "unique, random not counted"
STANDARDISED, RANDOM_SEARCH = "; medoids of standardised embeddings", "; random sampling instead of search"
"""What the simpler ways are called, after the representation's name."""
CHUNK = 250
"""Rollouts simulated at a time."""
ENOUGH = 5
"""Runs that a mean should be over; fewer are said so."""


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

    def summary(self) -> dict[str, Any]:
        """What the JSON says beside the means."""
        unique, chance = mean_and_error(self.unique), mean_and_error(self.count(RANDOM))
        return {
            "unique_each_run": self.unique, "unique_fewest": min(self.unique), "unique": (float(unique[0]), float(unique[1])),
            "random_each_run": self.count(RANDOM), "random": (float(chance[0]), float(chance[1])),
        }  # fmt: skip


def count_behaviours(groups: dict[str, list[Run]], simulator: Simulator | None) -> list[Found]:
    """Count what the runs found, and what simpler ways would have; random sampling only where a simulator is given."""
    simpler = random_searches(groups, simulator) if simulator is not None else []
    found = []
    for index, (name, runs) in enumerate(groups.items()):
        found += [medoids_found(name, runs), standardised_medoids(name, runs), *simpler[index : index + 1]]
    return found


def medoids_found(name: str, runs: list[Run]) -> Found:
    """Return the labels of the runs' own medoids."""
    return Found(name, [[medoid.label for medoid in run.medoids] for run in runs])


def standardised_medoids(name: str, runs: list[Run]) -> Found:
    """Return what the medoids would be of embeddings that are standardised first."""
    labels = []
    for run in runs:
        settings = dataclasses.replace(run.settings.clustering, standardise=True, whiten=False, wccn=False)
        labels.append(_labels_of_medoids(run.embeddings, run.archive.labels, run, settings))
    return Found(f"{name}{STANDARDISED}", labels)


def random_searches(groups: dict[str, list[Run]], simulator: Simulator) -> list[Found]:
    """Return what random controllers, as many as the search evaluated, would have given instead of the search.

    A seed's controllers are simulated once, whatever the number of representations that look at them.
    """
    drawn: dict[tuple[int, int], list[Run]] = {}
    for run in (run for runs in groups.values() for run in runs):
        drawn.setdefault((run.settings.seed, len(run.archive)), []).append(run)
    labels: dict[Path, list[str]] = {}
    with bar(sum(budget for _, budget in drawn), "random", "rollouts") as progress:
        for (seed, budget), runs in drawn.items():
            embeddings: list[list[npt.NDArray[np.float32]]] = [[] for _ in runs]
            names: list[str] = []
            for number, begin in enumerate(range(0, budget, CHUNK)):
                count = min(CHUNK, budget - begin)
                controllers = random_controllers(simulator.world, count, generator(seed, "random search", number))
                trajectories = simulator(controllers, whole_seed(seed, "random starts", number))
                names += label(trajectories)
                for run, parts in zip(runs, embeddings, strict=True):
                    parts.append(run.representation.embed(trajectories))
                progress.update(count)
            for run, parts in zip(runs, embeddings, strict=True):
                labels[run.path] = _labels_of_medoids(np.concatenate(parts), np.array(names), run)
    return [Found(f"{name}{RANDOM_SEARCH}", [labels[run.path] for run in runs]) for name, runs in groups.items()]


def _labels_of_medoids(
    embeddings: npt.NDArray[Any], labels: npt.NDArray[np.str_], run: Run, settings: ClusteringSettings | None = None
) -> list[str]:
    settings = settings or run.settings.clustering
    covariance = run.within_class_covariance if settings.wccn else None
    clusters = cluster(embeddings, settings, run.settings.seed, run.settings.search.distance, covariance=covariance)
    return list(labels[clusters.medoids].tolist())


def write_frequency(folder: Path, found: list[Found]) -> None:
    """Write ``behaviours.csv``, ``.json``, ``.png`` and ``.svg``; the paper's Table 1 stands beside."""
    head = ["way", "runs", "behaviour", "mean", "standard error", "each run", "paper's mean", "paper's standard error"]
    rows: list[list[Any]] = []
    for entry in found:
        theirs = published.counterpart(entry.name)
        for name, counts in [*((name, entry.count(name)) for name in BEHAVIOURS), (UNIQUE, entry.unique)]:
            mean, error = mean_and_error(counts)
            paper = _published(theirs, name)
            rows.append([entry.name, len(entry.labels), name, float(mean), float(error), " ".join(map(str, counts)), *paper])
    write_csv(folder / "behaviours.csv", head, rows, RULES)
    write_json(
        folder / "behaviours.json",
        {
            "labels_given_by": RULES,
            "fewer_runs_than_wanted": sorted(entry.name for entry in found if len(entry.labels) < ENOUGH),
            "rows": [dict(zip([key.replace("'s", "").replace(" ", "_") for key in head], row, strict=True)) for row in rows],
            "ways": {entry.name: entry.summary() for entry in found},
            "medoids": {entry.name: [dict(Counter(labels)) for labels in entry.labels] for entry in found},
        },
    )
    write_figure(draw(found), folder / "behaviours", RULES)


def _published(theirs: str | None, behaviour: str) -> tuple[float, float]:
    """Return the paper's mean and standard error, NaN where it has none."""
    nothing = (float("nan"), float("nan"))
    if theirs is None:
        return nothing
    return published.UNIQUE[theirs] if behaviour == UNIQUE else published.FREQUENCY[theirs].get(behaviour, nothing)


def draw(found: list[Found]) -> Any:
    """Return a figure of stacked mean counts, a bar for each way."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 0.34 * len(found) + 1.4), layout="constrained")
    axis = figure.subplots()
    left = np.zeros(len(found))
    names = [f"{entry.name} ({len(entry.labels)})" for entry in found]
    for name in BEHAVIOURS:
        means = np.array([np.mean(entry.count(name)) for entry in found])
        axis.barh(names, means, left=left, label=name, color=COLOURS[name])
        left += means
    axis.invert_yaxis()
    axis.set_xlabel("medoids, mean over runs")
    figure.legend(loc="outside upper right", fontsize=8, ncols=6, frameon=False)
    return figure

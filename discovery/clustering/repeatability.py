"""Which member of a cluster stands for it: the one that comes back to it from wherever the robots start.

A behaviour that hangs on one lucky start is poor news, and a rollout is one start. So the members nearest to each medoid are run again from
a few others; the one whose rollouts fall into the cluster most often takes the medoid's place, of equals the one whose rollouts lie nearest
to the medoid. Labels and metrics play no part: what they are is for a report to say afterwards, not for the search to know.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from discovery.clustering.embedding_space import clustering_space
from discovery.randomness import whole_seed
from discovery.representations.interface import Representation
from discovery.rollouts.simulator import Simulator
from discovery.runs.archive import Archive
from discovery.runs.clusters import Clusters
from discovery.settings import Settings

STARTS = 3
"""Starts that each candidate is run from, the same for all."""


@dataclass(frozen=True)
class Repeatability:
    """What became of trying members from other starts."""

    clusters: Clusters
    """With the most repeatable member of those tried in each medoid's place."""
    returned: npt.NDArray[np.float64]
    """(k,) share of the chosen members' rollouts that fell into their cluster."""
    before: npt.NDArray[np.float64]
    """(k,) the same for the medoids themselves."""
    rollouts: int
    """How many were made, beside the search's evaluations."""

    def summary(self) -> dict[str, Any]:
        """What ``metrics.json`` says of it."""
        return {"rollouts": self.rollouts, "returned": self.returned.tolist(), "returned_of_medoids": self.before.tolist()}


def most_repeatable(
    clusters: Clusters,
    archive: Archive,
    simulator: Simulator,
    representation: Representation,
    settings: Settings,
    covariance: npt.NDArray[np.float64] | None = None,
) -> Repeatability:
    """Put the most repeatable of the ``clustering.repeatable`` members nearest to each medoid in its place; the clusters stay as they are.

    ``covariance`` is what :func:`discovery.clustering.medoids.cluster` was given.
    """
    clustering = settings.clustering
    space = clustering_space(archive.embeddings, clustering, settings.search.distance, covariance)
    points = space.transform(archive.embeddings)
    medoids = points[clusters.medoids]
    candidates = [
        _nearest(space.distances(points, medoids[each : each + 1])[:, 0], clusters, each, clustering.repeatable)
        for each in range(len(medoids))
    ]
    rows, home = np.concatenate(candidates), np.repeat(np.arange(len(medoids)), [len(each) for each in candidates])
    runs = simulator(np.repeat(archive.controllers[rows], STARTS, axis=0), whole_seed(settings.seed, "stability"))
    away = space.distances(space.transform(representation.embed(runs)), medoids).reshape(len(rows), STARTS, len(medoids))
    returned = (away.argmin(axis=2) == home[:, None]).mean(axis=1)
    distance = np.take_along_axis(away, home[:, None, None], axis=2).mean(axis=(1, 2))
    # candidates of a cluster come nearest first: the medoid itself wins ties
    best = np.array([min(np.flatnonzero(home == each), key=lambda row: (-returned[row], distance[row])) for each in range(len(medoids))])
    first = np.searchsorted(home, np.arange(len(medoids)))
    return Repeatability(dataclasses.replace(clusters, medoids=rows[best]), returned[best], returned[first], len(rows) * STARTS)


def _nearest(distances: npt.NDArray[np.float32], clusters: Clusters, which: int, count: int) -> npt.NDArray[np.int64]:
    """Rows of the members of a cluster nearest to its medoid, the medoid first."""
    members = np.flatnonzero(clusters.labels == which)
    order = np.lexsort((members, distances[members], members != clusters.medoids[which]))
    return members[order][:count]

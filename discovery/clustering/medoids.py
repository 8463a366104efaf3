"""From the archive to a few behaviours: k-medoids (paper, Behavior Discovery)."""

from __future__ import annotations

from typing import Any

import kmedoids
import numpy as np
import numpy.typing as npt

from discovery.clustering.embedding_space import clustering_space
from discovery.randomness import generator, whole_seed
from discovery.runs.clusters import Clusters
from discovery.settings import ClusteringSettings

Rows = npt.NDArray[np.int64]

SAMPLES = 5
"""Samples that a large archive is clustered by; the one whose medoids suit the whole archive best counts (Kaufman and Rousseeuw 1990)."""


def cluster(
    embeddings: npt.NDArray[Any],
    settings: ClusteringSettings,
    seed: int,
    distance: str = "euclidean",
    members: Rows | None = None,
    covariance: npt.NDArray[np.float64] | None = None,
) -> Clusters:
    """Cluster embeddings (N, d) by FasterPAM, those of more than ``settings.sample`` by CLARA.

    One thread and a fixed random state: the same embeddings give the same medoids.

    Args:
        embeddings: Of everything evaluated; all of it is given a cluster.
        settings: Number of medoids, and how embeddings are compared.
        seed: The run's.
        distance: ``euclidean`` or ``cosine``.
        members: (M,) rows that medoids are of; None: all.
        covariance: (d, d) within classes, with ``settings.wccn`` and only then.

    Raises:
        ValueError: When there is a covariance and ``settings.wccn`` asks for none, or the other way round.
    """
    space = clustering_space(embeddings, settings, distance, covariance)
    points = space.transform(embeddings)
    rows = np.arange(len(points)) if members is None else members
    if len(rows) == len(points) <= settings.sample:
        result = _pam(space.distances(points, points), settings.medoids, whole_seed(seed, "medoids"))
        return by_size(np.asarray(result.medoids, dtype=np.int64), np.asarray(result.labels, dtype=np.int64))
    best, medoids, labels = np.inf, np.empty(0, np.int64), np.empty(0, np.int64)
    for number in range(SAMPLES if len(rows) > settings.sample else 1):
        chosen = rows
        if len(rows) > settings.sample:
            chosen = rows[np.sort(generator(seed, "medoid sample", number).choice(len(rows), settings.sample, replace=False))]
        sample = points[chosen]
        tried = chosen[_pam(space.distances(sample, sample), settings.medoids, whole_seed(seed, "medoids", number)).medoids]
        away = space.distances(points, points[tried])
        away[tried, np.arange(len(tried))] = -1.0  # a medoid's duplicate in another cluster must not claim it
        if (total := float(away[rows].min(axis=1).sum(dtype=np.float64))) < best:
            best, medoids, labels = total, tried.astype(np.int64), away.argmin(axis=1)
    return by_size(medoids, labels)


def _pam(distances: npt.NDArray[np.float32], medoids: int, seed: int) -> Any:
    # the library takes 31 bits
    return kmedoids.fasterpam(distances, medoids, init="build", random_state=seed >> 1, n_cpu=1)


def by_size(medoids: npt.NDArray[np.int64], labels: npt.NDArray[np.int64]) -> Clusters:
    """Number clusters from the largest to the smallest; of equals the earlier medoid comes first."""
    sizes = np.bincount(labels, minlength=len(medoids))
    order = np.lexsort((medoids, -sizes))
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    return Clusters(medoids[order], rank[labels])

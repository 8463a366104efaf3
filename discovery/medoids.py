"""From the archive to a few behaviours: k-medoids (paper, Behavior Discovery)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import kmedoids
import numpy as np
import numpy.typing as npt
from scipy.spatial.distance import cdist

from discovery.randomness import whole_seed
from discovery.settings import ClusteringSettings


@dataclass(frozen=True)
class Clusters:
    """Clusters of an archive, the largest first."""

    medoids: npt.NDArray[np.int64]
    """(k,) the archive row at the heart of each cluster."""
    labels: npt.NDArray[np.int64]
    """(N,) the cluster of each row, 0 to k - 1."""

    def share(self) -> npt.NDArray[np.float64]:
        """Share of the archive in each cluster, (k,)."""
        return np.bincount(self.labels, minlength=len(self.medoids)) / len(self.labels)

    def is_medoid(self) -> npt.NDArray[np.bool_]:
        """Whether each row is a medoid, (N,)."""
        flags = np.zeros(len(self.labels), dtype=np.bool_)
        flags[self.medoids] = True
        return flags


def cluster(embeddings: npt.NDArray[Any], settings: ClusteringSettings, seed: int) -> Clusters:
    """Cluster embeddings (N, d) by FasterPAM on Euclidean distances.

    One thread and a fixed random state: the same embeddings give the same medoids.
    """
    distances = cdist(embeddings, embeddings).astype(np.float32)
    state = whole_seed(seed, "medoids") >> 1  # the library takes 31 bits
    result = kmedoids.fasterpam(distances, settings.medoids, init="build", random_state=state, n_cpu=1)
    return by_size(np.asarray(result.medoids, dtype=np.int64), np.asarray(result.labels, dtype=np.int64))


def by_size(medoids: npt.NDArray[np.int64], labels: npt.NDArray[np.int64]) -> Clusters:
    """Number clusters from the largest to the smallest; of equals the earlier medoid comes first."""
    sizes = np.bincount(labels, minlength=len(medoids))
    order = np.lexsort((medoids, -sizes))
    rank = np.empty(len(order), dtype=np.int64)
    rank[order] = np.arange(len(order))
    return Clusters(medoids[order], rank[labels])

"""The space in which an archive is clustered: embeddings as they are, standardised or whitened, Euclidean or by direction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from sklearn.metrics.pairwise import euclidean_distances

from discovery.search.novelty import unit
from discovery.settings import ClusteringSettings

KEPT = 0.99
"""Share of the variance in the principal components that whitening keeps: the others are noise, which it would blow up."""

Float32 = npt.NDArray[np.float32]


@dataclass(frozen=True)
class Space:
    """Places embeddings, and says how far they are from one another."""

    mean: npt.NDArray[np.float64]
    """(d,) taken away first."""
    turn: npt.NDArray[np.float64] | None
    """(d, m) what is multiplied with then; None: nothing."""
    distance: str
    """euclidean or cosine."""

    def place(self, embeddings: npt.NDArray[Any]) -> Float32:
        """Return places (N, m) of embeddings (N, d)."""
        moved = embeddings - self.mean
        placed = moved if self.turn is None else moved @ self.turn
        return unit(placed) if self.distance == "cosine" else np.asarray(placed, dtype=np.float32)

    def distances(self, first: Float32, second: Float32) -> Float32:
        """Return distances (N, M) between places (N, m) and (M, m)."""
        # products in float64, a strip at a time: exact to float32 and far faster than one difference after the other
        strips = [euclidean_distances(part, second) for part in np.array_split(first, max(1, len(first) // 4096))]
        found = np.concatenate(strips) if len(first) else np.empty((0, len(second)), dtype=np.float32)
        return np.asarray(0.5 * found**2 if self.distance == "cosine" else found, dtype=np.float32)


def clustering_space(
    embeddings: npt.NDArray[Any], settings: ClusteringSettings, distance: str, turn: npt.NDArray[np.float64] | None
) -> Space:
    """Return the space that a run's archive is clustered in.

    Args:
        embeddings: (N, d).
        settings: How embeddings are compared.
        distance: ``euclidean`` or ``cosine``.
        turn: (d, m) what embeddings are multiplied with first, with ``settings.by_chance`` and only then.

    Raises:
        ValueError: When there is a turn and none is asked for, or the other way round.
    """
    if settings.by_chance != (turn is not None):
        given = "none" if turn is None else "one"
        raise ValueError(f"clustering.by_chance is {settings.by_chance}, given {given} of discovery.clustering.wccn.in_units_of")
    return make_space(embeddings, distance, settings.standardise, settings.whiten, turn)


def make_space(
    embeddings: npt.NDArray[Any],
    distance: str = "euclidean",
    standardise: bool = False,
    whiten: bool = False,
    turn: npt.NDArray[np.float64] | None = None,
) -> Space:
    """Return the space that suits an archive's embeddings (N, d).

    Args:
        embeddings: Give mean, scale and principal components.
        distance: ``euclidean``, or ``cosine``: one less the cosine of the angle, at the mean when there is one, else at the origin.
        standardise: Whether every number has mean 0 and standard deviation 1.
        whiten: Whether the principal components that hold most of the variance do, after that.
        turn: (d, m) what embeddings are multiplied with instead, such as :func:`discovery.clustering.wccn.in_units_of`.

    Raises:
        ValueError: When embeddings are to be multiplied and standardised or whitened.
    """
    wide = np.asarray(embeddings, dtype=np.float64)
    mean = np.zeros(wide.shape[1])
    if turn is not None:
        if standardise or whiten:
            raise ValueError("given a turn and standardise or whiten, expected one of them")
        return Space(wide.mean(axis=0), turn, distance)
    if standardise or whiten:
        mean = wide.mean(axis=0)
    if standardise:
        scale = wide.std(axis=0)
        turn = np.diag(1.0 / np.where(scale > 0, scale, 1.0))
    if whiten:
        moved = wide - mean if turn is None else (wide - mean) @ turn
        variances, axes = np.linalg.eigh(moved.T @ moved / len(moved))
        variances, axes = np.maximum(variances[::-1], 0.0), axes[:, ::-1]
        count = int(np.searchsorted(np.cumsum(variances), KEPT * variances.sum())) + 1
        count = min(count, max(1, int((variances > 0).sum())))
        scaled = axes[:, :count] / np.sqrt(np.where(variances[:count] > 0, variances[:count], 1.0))
        turn = scaled if turn is None else turn @ scaled
    return Space(mean, turn, distance)

"""The space in which an archive is clustered: embeddings as they are, standardised, whitened or after WCCN, Euclidean or by direction."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from sklearn.metrics.pairwise import euclidean_distances

from discovery.representations.affine import AffineTransform, FloatArray
from discovery.search.novelty import unit
from discovery.settings import ClusteringSettings

KEPT = 0.99
"""Share of the variance in the principal components that whitening keeps: the others are noise, which it would blow up."""

Float32 = npt.NDArray[np.float32]


@dataclass(frozen=True)
class EmbeddingSpace:
    """Transforms embeddings, and says how far they are from one another."""

    affine: AffineTransform | None
    """None: embeddings as they are."""
    distance: str
    """euclidean or cosine."""

    def transform(self, embeddings: npt.NDArray[Any]) -> Float32:
        """Return the points (N, m) of embeddings (N, d)."""
        points = embeddings if self.affine is None else self.affine(embeddings)
        return unit(points) if self.distance == "cosine" else np.asarray(points, dtype=np.float32)

    def distances(self, first: Float32, second: Float32) -> Float32:
        """Return distances (N, M) between points (N, m) and (M, m)."""
        # products in float64, a strip at a time: exact to float32 and far faster than one difference after the other
        strips = [euclidean_distances(part, second) for part in np.array_split(first, max(1, len(first) // 4096))]
        found = np.concatenate(strips) if len(first) else np.empty((0, len(second)), dtype=np.float32)
        return np.asarray(0.5 * found**2 if self.distance == "cosine" else found, dtype=np.float32)


def clustering_space(
    embeddings: npt.NDArray[Any], settings: ClusteringSettings, distance: str, covariance: FloatArray | None
) -> EmbeddingSpace:
    """Return the space that a run's archive is clustered in.

    Args:
        embeddings: (N, d).
        settings: How embeddings are compared.
        distance: ``euclidean`` or ``cosine``.
        covariance: (d, d) within classes, with ``settings.wccn`` and only then.

    Raises:
        ValueError: When there is a covariance and none is asked for, or the other way round.
    """
    if settings.wccn != (covariance is not None):
        given = "none" if covariance is None else "one"
        raise ValueError(f"clustering.wccn is {settings.wccn}, given {given} of discovery.clustering.wccn.within_class_covariance")
    return make_space(embeddings, distance, settings.standardise, settings.whiten, covariance)


def make_space(
    embeddings: npt.NDArray[Any],
    distance: str = "euclidean",
    standardise: bool = False,
    whiten: bool = False,
    covariance: FloatArray | None = None,
) -> EmbeddingSpace:
    """Return the space that suits an archive's embeddings (N, d).

    Args:
        embeddings: Give mean, scale and principal components.
        distance: ``euclidean``, or ``cosine``: one less the cosine of the angle, at the mean when there is one, else at the origin.
        standardise: Whether every number has mean 0 and standard deviation 1.
        whiten: Whether the principal components that hold most of the variance do, after that.
        covariance: (d, d) within classes, for WCCN instead.

    Raises:
        ValueError: When embeddings are to be normalised by a covariance and standardised or whitened.
    """
    if covariance is not None and (standardise or whiten):
        raise ValueError("given a covariance and standardise or whiten, expected one of them")
    return EmbeddingSpace(_affine(np.asarray(embeddings, dtype=np.float64), standardise, whiten, covariance), distance)


def _affine(embeddings: FloatArray, standardise: bool, whiten: bool, covariance: FloatArray | None) -> AffineTransform | None:
    if covariance is not None:
        return AffineTransform.within_class(embeddings.mean(axis=0), covariance)
    if whiten:
        return AffineTransform.whitening(embeddings, KEPT, standardise)
    if standardise:
        return AffineTransform.standardising(embeddings)
    return None

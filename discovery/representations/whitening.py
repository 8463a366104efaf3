"""Embeddings brought to a common scale, so that no direction of theirs outweighs the others for being long alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from discovery.errors import DiscoveryError

Embeddings = npt.NDArray[np.float32]


@dataclass(frozen=True)
class Whitening:
    """``(embedding - mean) @ directions``."""

    mean: Embeddings
    """(d,)"""
    directions: Embeddings
    """(d, kept)"""

    def __call__(self, embeddings: Embeddings) -> Embeddings:
        """Bring embeddings (N, d) to the common scale: (N, kept)."""
        return np.asarray((embeddings - self.mean) @ self.directions, dtype=np.float32)


def fit_whitening(embeddings: Embeddings, method: str, variance: float) -> Whitening:
    """Return what gives embeddings (N, d) mean 0 and standard deviation 1.

    Args:
        embeddings: Of the dataset.
        method: ``standardise`` (each number by itself) or ``pca`` (each principal component, which leaves them uncorrelated).
        variance: Share of the variance that the kept principal components hold; the others are small and mostly noise, which would be
            blown up to the same size.

    Raises:
        DiscoveryError: When all embeddings are the same.
    """
    given = embeddings.astype(np.float64)
    mean = given.mean(axis=0)
    spread = given.std(axis=0)
    if not spread.max() > 0.0:
        raise DiscoveryError("representation.whiten: every video of the dataset has the same embedding; take whiten=none or other videos")
    if method == "standardise":
        # a number that never changes is left alone
        directions = np.diag(1.0 / np.where(spread > 1e-6 * spread.max(), spread, 1.0))
    else:
        _, singular, components = np.linalg.svd(given - mean, full_matrices=False)
        held = np.cumsum(singular**2) / np.sum(singular**2)
        kept = min(int(np.searchsorted(held, variance)) + 1, int(np.sum(singular > 1e-6 * singular[0])))
        directions = components[:kept].T * (np.sqrt(len(given)) / singular[:kept])
    return Whitening(mean.astype(np.float32), np.ascontiguousarray(directions, dtype=np.float32))

"""The five hand-crafted metrics, concatenated with what a network sees: pictures tell some behaviours apart, the metrics others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from discovery.errors import DiscoveryError
from discovery.representations.square_root_scaling import with_square_roots

Embeddings = npt.NDArray[np.float32]

METRICS = 5
"""Numbers that are concatenated with an embedding."""


@dataclass(frozen=True)
class ConcatenatedMetrics:
    """Embedding and metrics in one row, each over a scale of its own."""

    embedding: float
    """What embeddings are divided by."""
    metrics: float
    """What metrics are divided by."""
    square_root: bool = False
    """Whether radial variance and scatter enter by their square roots."""

    def __call__(self, embeddings: Embeddings, metrics: npt.NDArray[np.float64]) -> Embeddings:
        """Join embeddings (N, d) and metrics (N, 5): (N, d + 5)."""
        taken = with_square_roots(metrics) if self.square_root else metrics
        return np.hstack([embeddings / self.embedding, taken / self.metrics], dtype=np.float32, casting="same_kind")


def fit_concatenated_metrics(
    embeddings: Embeddings, metrics: npt.NDArray[np.float64], weight: float, square_root: bool = False
) -> ConcatenatedMetrics:
    """Return what has the metrics vary ``weight`` times as much as the embeddings, as root mean square over the dataset.

    The metrics are not standardised among themselves: those tell behaviours apart less well.

    Args:
        embeddings: Of the dataset, (N, d).
        metrics: Of the dataset, (N, 5).
        weight: Above 0.
        square_root: Whether radial variance and scatter enter by their square roots, instead of raw as published.

    Raises:
        DiscoveryError: When all embeddings, or all metrics, are the same.
    """
    parts = (embeddings.astype(np.float64), with_square_roots(metrics) if square_root else metrics)
    spreads = [float(np.sqrt(np.square(part - part.mean(axis=0)).sum(axis=1).mean())) for part in parts]
    if min(spreads) == 0.0:
        what = "embedding" if spreads[0] == 0.0 else "metrics"
        raise DiscoveryError(f"representation.metrics: every video of the dataset has the same {what}; take metrics=0 or other videos")
    return ConcatenatedMetrics(spreads[0], spreads[1] / weight, square_root)

"""The five hand-crafted metrics beside what a network sees: pictures tell some behaviours apart, the metrics others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from discovery.errors import DiscoveryError

Embeddings = npt.NDArray[np.float32]

METRICS = 5
"""Numbers that stand beside an embedding."""


@dataclass(frozen=True)
class Beside:
    """Embedding and metrics in one row, each over a scale of its own."""

    embedding: float
    """What embeddings are divided by."""
    metrics: float
    """What metrics are divided by."""

    def __call__(self, embeddings: Embeddings, metrics: npt.NDArray[np.float64]) -> Embeddings:
        """Join embeddings (N, d) and metrics (N, 5): (N, d + 5)."""
        return np.hstack([embeddings / self.embedding, metrics / self.metrics], dtype=np.float32, casting="same_kind")


def fit_beside(embeddings: Embeddings, metrics: npt.NDArray[np.float64], weight: float) -> Beside:
    """Return what has the metrics vary ``weight`` times as much as the embeddings, as root mean square over the dataset.

    The metrics stay raw, as published, among themselves: standardised ones tell behaviours apart less well.

    Args:
        embeddings: Of the dataset, (N, d).
        metrics: Of the dataset, (N, 5).
        weight: Above 0.

    Raises:
        DiscoveryError: When all embeddings, or all metrics, are the same.
    """
    spreads = [float(np.sqrt(np.square(part - part.mean(axis=0)).sum(axis=1).mean())) for part in (embeddings.astype(np.float64), metrics)]
    if min(spreads) == 0.0:
        what = "embedding" if spreads[0] == 0.0 else "metrics"
        raise DiscoveryError(f"representation.metrics: every video of the dataset has the same {what}; take metrics=0 or other videos")
    return Beside(spreads[0], spreads[1] / weight)

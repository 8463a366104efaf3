"""The clusters of an archive and their medoids."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt


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

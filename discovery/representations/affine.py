"""One affine map of embeddings, and the three ways to fit it: standardising, whitening, within-class covariance normalisation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

SMALLEST = 1e-6
"""Standard deviation of the smallest principal component that or number that is scaled, as a share of the largest's: below is rounding."""
SHRINKAGE = 0.1
"""Share of a within-class covariance that is replaced by the same in every direction: in directions where the classes hardly vary, few of
them say little."""


@dataclass(frozen=True)
class AffineTransform:
    """``(row - mean) @ matrix``."""

    mean: npt.NDArray[Any]
    """(d,)"""
    matrix: npt.NDArray[Any]
    """(d, m)"""

    def __call__(self, rows: npt.NDArray[Any]) -> npt.NDArray[Any]:
        """Transform rows (N, d): (N, m)."""
        return np.asarray((rows - self.mean) @ self.matrix)

    @property
    def dimension(self) -> int:
        """Numbers in a transformed row, m."""
        return int(self.matrix.shape[1])

    def in_single_precision(self) -> Self:
        """Return the same transform in float32, which keeps float32 rows so."""
        return type(self)(self.mean.astype(np.float32), np.ascontiguousarray(self.matrix, dtype=np.float32))

    @classmethod
    def standardising(cls, rows: npt.NDArray[Any], smallest: float = 0.0) -> Self:
        """Return what gives every number of rows (N, d) mean 0 and standard deviation 1.

        A number whose standard deviation is at most ``smallest`` times the largest of all is left as large as it is.
        """
        wide = np.asarray(rows, dtype=np.float64)
        spread = wide.std(axis=0)
        return cls(wide.mean(axis=0), np.diag(1.0 / np.where(spread > smallest * spread.max(), spread, 1.0)))

    @classmethod
    def whitening(cls, rows: npt.NDArray[Any], variance: float, standardise: bool = False) -> Self:
        """Return what gives the principal components of rows (N, d) mean 0 and standard deviation 1.

        Args:
            rows: (N, d).
            variance: Share of the variance that the kept components hold; the others are small and mostly noise, which would be blown up
                to the same size.
            standardise: Whether every number is standardised before the components are taken.
        """
        wide = np.asarray(rows, dtype=np.float64)
        mean, first = wide.mean(axis=0), cls.standardising(wide) if standardise else None
        _, singular, components = np.linalg.svd(wide - mean if first is None else first(wide), full_matrices=False)
        if singular[0] == 0.0:
            return cls(mean, components[:1].T)  # all rows are the same
        held = np.cumsum(singular**2) / np.sum(singular**2)
        kept = min(int(np.searchsorted(held, variance)) + 1, int(np.sum(singular > SMALLEST * singular[0])))
        scaled = components[:kept].T * (np.sqrt(len(wide)) / singular[:kept])
        return cls(mean, scaled if first is None else first.matrix @ scaled)

    @classmethod
    def within_class(cls, mean: FloatArray, covariance: FloatArray) -> Self:
        """Return what gives distances in units of a within-class covariance (WCCN, Hatch and others 2006): its root's inverse, shrunk.

        Args:
            mean: (d,) of the rows to be transformed.
            covariance: (d, d) of rows about the means of their classes.
        """
        scale = np.trace(covariance) / len(covariance)
        if scale == 0.0:
            return cls(mean, np.eye(len(covariance)))  # rows of a class are all the same
        variances, axes = np.linalg.eigh((1.0 - SHRINKAGE) * covariance + SHRINKAGE * scale * np.eye(len(covariance)))
        return cls(mean, np.asarray((axes / np.sqrt(variances)) @ axes.T))

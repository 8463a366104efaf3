"""Metrics that are lengths instead of squared lengths."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

SQUARED = (2, 3)
"""Columns of radial variance and scatter among the five metrics (Brown et al. 2018)."""


def with_square_roots(metrics: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return metrics (N, 5) with the square roots of radial variance and scatter in their columns.

    Both are squared lengths over a squared radius: as they are, wide swarms lie far apart from one another and narrow ones close together.
    """
    rooted = np.array(metrics, dtype=np.float64)
    rooted[:, SQUARED] = np.sqrt(rooted[:, SQUARED])
    return rooted

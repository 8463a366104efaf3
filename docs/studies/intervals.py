"""Intervals of rates, for the studies that count."""

from __future__ import annotations

import math

Z = 1.959964
"""Standard score of a 95 % interval."""


def wilson(hits: int, trials: int) -> tuple[float, float]:
    """Return Wilson's 95 % interval of a rate; (0, 1) without trials (Wilson 1927; Newcombe 1998, method 3)."""
    if trials == 0:
        return 0.0, 1.0
    rate, scale = hits / trials, 1 + Z * Z / trials
    middle = (rate + Z * Z / (2 * trials)) / scale
    half = Z / scale * math.sqrt(rate * (1 - rate) / trials + Z * Z / (4 * trials * trials))
    return max(0.0, middle - half), min(1.0, middle + half)

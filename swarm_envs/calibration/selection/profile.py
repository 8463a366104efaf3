"""Bounds of a parameter by the profile of its likelihood."""

from __future__ import annotations

from collections.abc import Callable


def edge(drop: Callable[[float], float], value: float, bound: float) -> float:
    """Return the parameter between ``value`` and ``bound`` at which the likelihood has fallen by 1.92."""
    inside, outside = value, bound
    for _ in range(30):
        middle = 0.5 * (inside + outside)
        if drop(middle) < 1.92:
            inside = middle
        else:
            outside = middle
        if abs(inside - outside) < 1e-3 * abs(bound - value):
            break
    return 0.5 * (inside + outside)

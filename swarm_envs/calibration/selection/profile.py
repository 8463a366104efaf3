"""Bounds of a parameter by the profile of its likelihood."""

from __future__ import annotations

from collections.abc import Callable

DROP = 1.92
"""Fall of the log-likelihood at the bounds of a 95 % interval: half the quantile of chi-squared with one degree of freedom."""
BISECTIONS = 30
"""At most."""


def profile_likelihood_bound(drop: Callable[[float], float], value: float, bound: float) -> float:
    """Return the parameter between ``value`` and ``bound`` at which the log-likelihood has fallen by :data:`DROP`.

    Args:
        drop: From the parameter to the fall of the log-likelihood below its maximum, in nats.
        value: The likeliest.
        bound: The farthest that is looked at.
    """
    inside, outside = value, bound
    for _ in range(BISECTIONS):
        middle = 0.5 * (inside + outside)
        if drop(middle) < DROP:
            inside = middle
        else:
            outside = middle
        if abs(inside - outside) < 1e-3 * abs(bound - value):
            break
    return 0.5 * (inside + outside)

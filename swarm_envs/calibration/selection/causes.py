"""An effect that was named, with its numbers."""

from __future__ import annotations

from dataclasses import dataclass

SIGNIFICANT = 0.01
"""Greatest p-value, corrected for the number of candidates, at which an effect is named."""
CLOSE = 3.0
"""Candidates whose log-likelihoods differ by less than this cannot be told apart."""


@dataclass(frozen=True)
class Estimate:
    """One number with its interval."""

    estimate: float
    ci95: tuple[float, float]
    unit: str


@dataclass(frozen=True)
class Cause:
    """An effect that was named."""

    effect: str
    parameters: dict[str, Estimate]
    heldout_gain: float
    """Log-likelihood gained on held-out poses when the effect is added to those named before, in nats."""
    p_value: float
    """Of the effect being absent, corrected for the number of candidates tried."""
    explanation: str

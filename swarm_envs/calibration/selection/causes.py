"""Effects that were named, with their numbers."""

from __future__ import annotations

from dataclasses import dataclass


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
    """Log-likelihood gained on held-out runs when the effect is added to those named before, in nats."""
    p_value: float
    """Of the effect being absent, corrected for the number of candidates tried."""
    explanation: str


@dataclass(frozen=True)
class Named:
    """Which effects explain a part of a log."""

    causes: tuple[Cause, ...]
    indistinguishable: tuple[tuple[str, ...], ...]
    """Groups of confounded effects, which these data cannot tell apart."""
    rejected: tuple[tuple[str, float], ...]
    """Effects tried last and not named, each with its corrected p-value."""


NOTHING = Named((), (), ())
"""Where a log has too little of what would show an effect."""

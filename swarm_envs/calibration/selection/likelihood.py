"""What forward selection asks of a likelihood: models with and without an effect, and how large an effect must be to matter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar

ModelT = TypeVar("ModelT")
"""Whatever holds a model's parameters."""


class HasLogLikelihood(Protocol):
    """A fit."""

    @property
    def log_likelihood(self) -> float:
        """In nats."""


FitT = TypeVar("FitT", bound=HasLogLikelihood)
"""A model at its likelihood's maximum, and whatever else a fit leaves."""


@dataclass(frozen=True)
class Fitted(Generic[ModelT]):
    """A model at its likelihood's maximum."""

    model: ModelT
    log_likelihood: float
    """In nats."""


@dataclass(frozen=True)
class Trial(Generic[ModelT]):
    """A candidate added to a model."""

    name: str
    model: ModelT
    gain: float
    """In log-likelihood over the fit without it, in nats."""
    numbers: int = 1
    """Parameters that it adds."""

    @property
    def penalised_gain(self) -> float:
        """The gain less a penalty for each parameter, which gains something by chance."""
        return self.gain - 2.0 * self.numbers


class Likelihood(Protocol[ModelT, FitT]):
    """A log's likelihood under models with some effects; effects go by their names."""

    @property
    def candidates(self) -> Sequence[str]:
        """Effects that may be named, simplest first."""

    def confounded_with(self, name: str) -> Sequence[str]:
        """Return the effects that no such log can tell from one."""

    def numbers(self, name: str) -> int:
        """Return the number of an effect's parameters."""

    def propose(self, fit: FitT, named: Sequence[str], candidates: Sequence[str]) -> list[Trial[ModelT]]:
        """Add each of some candidates to the fit with the named effects."""

    def refit(self, model: ModelT, named: Sequence[str]) -> FitT:
        """Fit all named effects and what else the model leaves free, starting from a model."""

    def without(self, fit: FitT, others: Sequence[str], name: str) -> FitT:
        """Fit again with one effect as the world has it; ``others`` stay named."""

    def overdispersion(self, fit: FitT, trial: Trial[ModelT]) -> float:
        """Return how much more the gain varies than a right model's would, at least 1."""

    def is_large_enough(self, fit: FitT, trial: Trial[ModelT]) -> bool:
        """Whether a candidate reaches its minimum effect size."""

    def is_negligible(self, fit: FitT, name: str) -> bool:
        """Whether a named effect has fallen below its minimum effect size."""

    def heldout_gain(self, fit: FitT, named: Sequence[str], trial: Trial[ModelT]) -> float:
        """Return what a candidate gains, in nats, on runs that it was not fitted to."""

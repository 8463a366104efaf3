"""What sensor and contact share: models of a few numbers, each of which is an effect that may be named."""

from __future__ import annotations

import dataclasses
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, Self, TypeVar

from swarm_envs.calibration.selection.causes import Cause, Estimate, Named
from swarm_envs.calibration.selection.forward import Selected
from swarm_envs.calibration.selection.likelihood import Fitted, Trial


@dataclass(frozen=True)
class Numbers:
    """A model of numbers; one that an effect may change has the effect's name."""

    def value(self, name: str) -> float:
        """Return the number of this name."""
        return float(getattr(self, name))

    def with_value(self, name: str, value: float) -> Self:
        """Return a copy with another number of this name."""
        changes: dict[str, float] = {name: value}
        return dataclasses.replace(self, **changes)


NumbersT = TypeVar("NumbersT", bound=Numbers)


@dataclass(frozen=True)
class Effect:
    """An effect of one number that may be named."""

    name: str
    parameter: str
    """Name of the number, as the findings call it."""
    place: str
    """Where a world has it, a part and its field; see :func:`swarm_envs.calibration.apply_effects.with_number`."""
    unit: str
    """SI unit."""
    minimum_effect: float
    """Departure that is too small to matter, or to be told from errors of the poses."""
    sentence: str
    """What it means, for a person; the parameter in braces."""


class OneNumberEffects(ABC, Generic[NumbersT]):
    """A likelihood, as forward selection asks for it, under models whose effects have one number each.

    Args:
        base: What the world has.
        effects: That may be named, in the order in which they are tried.
    """

    def __init__(self, base: NumbersT, effects: Sequence[Effect]) -> None:
        self.base = base
        self.effects = {effect.name: effect for effect in effects}

    @abstractmethod
    def propose(self, fit: Fitted[NumbersT], named: Sequence[str], candidates: Sequence[str]) -> list[Trial[NumbersT]]:
        """Add each of some candidates to the fit with the named effects."""

    @abstractmethod
    def refit(self, model: NumbersT, named: Sequence[str]) -> Fitted[NumbersT]:
        """Fit all named effects, starting from a model."""

    @abstractmethod
    def heldout_gain(self, fit: Fitted[NumbersT], named: Sequence[str], trial: Trial[NumbersT]) -> float:
        """Return what a candidate gains, in nats, on runs that it was not fitted to."""

    @abstractmethod
    def estimate(self, fit: Fitted[NumbersT], named: Sequence[str], name: str) -> Estimate:
        """Return a named effect's number with its interval."""

    @property
    def candidates(self) -> tuple[str, ...]:
        """Effects that may be named."""
        return tuple(self.effects)

    def confounded_with(self, name: str) -> tuple[str, ...]:
        """None of these effects is like another by nature."""
        return ()

    def numbers(self, name: str) -> int:
        """One for each effect."""
        return 1

    def without(self, fit: Fitted[NumbersT], others: Sequence[str], name: str) -> Fitted[NumbersT]:
        """Fit again with one number as the world has it."""
        return self.refit(fit.model.with_value(name, self.base.value(name)), others)

    def overdispersion(self, fit: Fitted[NumbersT], trial: Trial[NumbersT]) -> float:
        """What the likelihood is of is taken for independent."""
        return 1.0

    def is_large_enough(self, fit: Fitted[NumbersT], trial: Trial[NumbersT]) -> bool:
        """Whether a candidate departs from the world by more than its minimum effect size."""
        return self._departs(trial.model, trial.name)

    def is_negligible(self, fit: Fitted[NumbersT], name: str) -> bool:
        """Whether a named effect departs from the world by no more than that."""
        return not self._departs(fit.model, name)

    def _departs(self, model: NumbersT, name: str) -> bool:
        return abs(model.value(name) - self.base.value(name)) > self.effects[name].minimum_effect

    def named(self, selected: Selected[Fitted[NumbersT]]) -> Named:
        """Describe what a selection ended with."""
        causes = []
        for name, evidence in selected.evidence.items():
            effect, number = self.effects[name], self.estimate(selected.fit, list(selected.evidence), name)
            sentence = effect.sentence.format(**{effect.parameter: number.estimate})
            causes.append(Cause(name, {effect.parameter: number}, evidence.heldout_gain, evidence.p_value, sentence))
        return Named(tuple(causes), selected.confounded, selected.rejected)

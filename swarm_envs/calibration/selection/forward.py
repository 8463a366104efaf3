"""Forward selection: effects are named one after the other while each is real, and dropped when a later one makes them needless.

An effect is real when its likelihood ratio is significant, corrected for the number of candidates tried, when it reaches its minimum
effect size, and when it predicts held-out runs better. What the likelihood is of, poses, readings or contacts, makes no difference here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Generic

from scipy.stats import chi2

from swarm_envs.calibration.selection.likelihood import FitT, Likelihood, ModelT, Trial

SIGNIFICANT = 0.01
"""Greatest p-value, corrected for the number of candidates, at which an effect is named."""
CLOSE = 3.0
"""Candidates whose penalised gains differ by less than this are confounded: the data cannot tell them apart."""
SHOWN = 4
"""Candidates of a round that a line of progress tells of."""


@dataclass(frozen=True)
class Rules:
    """How far a selection goes."""

    most: int
    """At most so many effects are named."""
    examined: int
    """So many of a round's best candidates are held against held-out runs."""
    tried: int
    """Candidates that there are, for which p-values of the backward elimination are corrected."""
    always_all: bool = False
    """Whether those of naming are corrected for all of them, too, and not for those of the round."""
    eliminates: bool = True
    """Whether effects that a later one has made needless are dropped."""
    kept: frozenset[str] = frozenset()
    """Effects that are never dropped."""
    label: str = ""
    """Beginning of the lines of progress."""


@dataclass(frozen=True)
class Evidence:
    """Why an effect was named."""

    heldout_gain: float
    """In nats; NaN for what was given from the start."""
    p_value: float


@dataclass(frozen=True)
class Selected(Generic[FitT]):
    """What a selection ends with."""

    fit: FitT
    """With all named effects."""
    evidence: dict[str, Evidence]
    """By effect, in the order of naming."""
    confounded: tuple[tuple[str, ...], ...]
    """Groups of effects that the data cannot tell apart, the named one first."""
    rejected: tuple[tuple[str, float], ...]
    """Candidates of the last round with their p-values."""


def p_value(gain: float, numbers: int, tried: int, overdispersion: float = 1.0) -> float:
    """Return the p-value of a gain in log-likelihood by some parameters, corrected for the number of candidates tried."""
    return float(min(1.0, tried * chi2.sf(2.0 * max(gain, 0.0) / overdispersion, numbers)))


@dataclass
class ForwardSelection(Generic[ModelT, FitT]):
    """A selection under way.

    Args:
        likelihood: Of the log.
        fit: Where the selection begins.
        rules: How far it goes.
        progress: Called with a line at each step.
        named: Effects that the first fit has already.
    """

    likelihood: Likelihood[ModelT, FitT]
    fit: FitT
    rules: Rules
    progress: Callable[[str], None]
    named: list[str] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.evidence = {name: Evidence(math.nan, 0.0) for name in self.named}
        self.groups: list[tuple[str, ...]] = []
        self.fruitless: set[str] = set()

    def run(self) -> Selected[FitT]:
        """Name effects while they are real."""
        rejected: tuple[tuple[str, float], ...] = ()
        while len(self.named) < self.rules.most:
            trials = self.trials()
            p_values = {trial.name: self.p_value(trial, len(trials)) for trial in trials}
            rejected = tuple(p_values.items())
            accepted = next((trial for trial in trials[: self.rules.examined] if self.is_real(trial, p_values[trial.name])), None)
            if accepted is None:
                break
            self.name(accepted, trials)
        by_nature = [(name, *self.likelihood.confounded_with(name)) for name in self.named if self.likelihood.confounded_with(name)]
        evidence = {name: self.evidence[name] for name in self.named}
        return Selected(self.fit, evidence, (*self.groups, *by_nature), rejected)

    def trials(self) -> list[Trial[ModelT]]:
        """Add every candidate that may be named to the fit, the best first."""
        taken = {other for name in self.named for other in self.likelihood.confounded_with(name)} | {*self.named} | self.fruitless
        candidates = [name for name in self.likelihood.candidates if name not in taken]
        trials = sorted(self.likelihood.propose(self.fit, self.named, candidates), key=lambda trial: -trial.penalised_gain)
        self.say(", ".join(f"{trial.name} {trial.gain:.1f}" for trial in trials[:SHOWN]))
        return trials

    def p_value(self, trial: Trial[ModelT], of_round: int) -> float:
        """Return a candidate's p-value."""
        tried = self.rules.tried if self.rules.always_all else of_round
        return p_value(trial.gain, trial.numbers, tried, self.likelihood.overdispersion(self.fit, trial))

    def is_real(self, trial: Trial[ModelT], p: float) -> bool:
        """Whether an effect is significant, large enough, and better on runs that were held out."""
        if p > SIGNIFICANT or not self.likelihood.is_large_enough(self.fit, trial):
            return False
        gained = self.likelihood.heldout_gain(self.fit, self.named, trial)
        self.say(f"{trial.name}: gain {trial.gain:.1f}, p {p:.2g}, held out {gained:.1f}")
        self.evidence[trial.name] = Evidence(gained, p)
        return gained > 0.0

    def name(self, accepted: Trial[ModelT], trials: Sequence[Trial[ModelT]]) -> None:
        """Name an effect, fit all again and drop what that makes needless."""
        close = [t.name for t in trials if t is not accepted and accepted.penalised_gain - t.penalised_gain < CLOSE]
        if close:
            self.groups.append((accepted.name, *close))
        self.named.append(accepted.name)
        self.fit = self.likelihood.refit(accepted.model, self.named)
        if self.rules.eliminates:
            self.eliminate()
        if accepted.name not in self.named:
            # it would be named and dropped in every round to come
            self.fruitless.add(accepted.name)

    def eliminate(self) -> None:
        """Drop named effects that a later one has made needless: backward elimination."""
        for name in [name for name in self.named if name not in self.rules.kept]:
            negligible = self.likelihood.is_negligible(self.fit, name)
            if name == self.named[-1] and not negligible:
                continue
            others = [other for other in self.named if other != name]
            without = self.likelihood.without(self.fit, others, name)
            lost = self.fit.log_likelihood - without.log_likelihood
            if negligible or p_value(lost, self.likelihood.numbers(name), self.rules.tried) > SIGNIFICANT:
                self.say(f"{name} is no longer needed")
                self.named, self.fit = others, without

    def say(self, text: str) -> None:
        """Tell of a step."""
        self.progress(self.rules.label + text)

"""Which effects of the drive explain a log."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from swarm_envs.calibration.drive.candidates import BY_NAME, SPREAD
from swarm_envs.calibration.drive.first_guess import in_other_units, initial_gains, initial_noise
from swarm_envs.calibration.drive.fitting import Fit, Model
from swarm_envs.calibration.drive.intervals import Intervals
from swarm_envs.calibration.drive.likelihood import TRIED, DriveLikelihood
from swarm_envs.calibration.drive.measured import Measured, measured
from swarm_envs.calibration.drive.parameters import INDEX, drive_parameters
from swarm_envs.calibration.drive.robot_spread import GAINS, ROBOT_SPREAD, Levelled, level_gains, spread_estimates
from swarm_envs.calibration.logs.log import Log
from swarm_envs.calibration.selection.causes import Cause, Estimate, Named
from swarm_envs.calibration.selection.forward import ForwardSelection, Rules
from swarm_envs.worlds import WorldSpec

RULES = Rules(most=6, examined=3, tried=TRIED, kept=frozenset({ROBOT_SPREAD}))
FOLDS = 6
"""Parts of the runs, each predicted by the named effects as the other runs have them."""
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Identified(Named):
    """What explains the drives of a log."""

    model: Model
    """The drive with the named effects, and the noise."""
    robots: tuple[str, ...]
    """Names of the robots, in the order of the model's gains."""
    gains_first: bool
    """Whether the commands were so far from SI units that gains were fitted before anything else."""
    data: Measured
    """What was fitted."""
    start: Model
    """The drive as the world had it, with the noise that explains the log then."""
    leave_out: Callable[[], tuple[Model, ...]] = field(repr=False, compare=False)
    """Computes :attr:`without`."""

    @cached_property
    def without(self) -> tuple[Model, ...]:
        """For each held-out group the model fitted to the others."""
        return self.leave_out()


@dataclass(frozen=True)
class _Start:
    """Where an identification begins."""

    likelihood: DriveLikelihood
    fit: Fit
    model: Model
    """The drive as the world has it, with the first guess of the noise."""
    gains_first: tuple[str, ...]
    """Gains that were fitted before anything else, if commands are far from SI units."""


def identify(log: Log, world: WorldSpec, progress: Progress = lambda text: None) -> Identified:
    """Name the effects of the drive that explain a log.

    Args:
        log: The log.
        world: What it is compared with; its own effects are where the search begins.
        progress: Called with a line at each step.

    Raises:
        LogError: When nothing in the log can be predicted.
    """
    start = _start(log, world)
    likelihood, data = start.likelihood, start.likelihood.data
    rules = dataclasses.replace(RULES, most=RULES.most + 2, kept=RULES.kept | {*start.gains_first}) if start.gains_first else RULES
    selected = ForwardSelection(likelihood, start.fit, rules, progress, list(start.gains_first)).run()
    found = Levelled(selected.fit, selected.evidence, {})
    if ROBOT_SPREAD in found.evidence:
        found = level_gains(found.fit, found.evidence)
    named = list(found.evidence)

    def leave_out() -> tuple[Model, ...]:
        return _without_each_fold(likelihood, found.fit, named, progress)

    parts = leave_out() if named else ()
    causes = _causes(likelihood, found, parts) if named else ()
    return Identified(
        causes, selected.confounded, selected.rejected, found.fit.model, data.robots, bool(start.gains_first), data, start.model,
        lambda: parts or leave_out(),
    )  # fmt: skip


def _start(log: Log, world: WorldSpec) -> _Start:
    """Fit the noise alone, or with the gains where commands are far from SI units."""
    data, base = measured(log), drive_parameters(world)
    gains = initial_gains(log, base)
    known = [name for name, gain in zip(GAINS, gains, strict=True) if np.isfinite(gain)]
    first = tuple(known) if in_other_units(log, gains) else ()
    if first:
        base[[INDEX[name] for name in GAINS]] *= [gain if np.isfinite(gain) else 1.0 for gain in gains]
    noise = initial_noise(data)
    likelihood = DriveLikelihood(data, base, noise)
    model = Model(base, noise, np.ones((len(data.robots), 2)))
    fit = likelihood.fit_noise(model)
    if first:
        fit = likelihood.refit(fit.model, first)
    return _Start(likelihood, fit, dataclasses.replace(model, parameters=drive_parameters(world)), first)


def _without_each_fold(likelihood: DriveLikelihood, fit: Fit, named: Sequence[str], progress: Progress) -> tuple[Model, ...]:
    """Return for each group the model with the named effects, fitted without the group's fold."""
    data = likelihood.data
    groups = len(data.runs)
    folds = min(FOLDS, groups)
    models: list[Model] = []
    for fold in range(folds):
        part = data.of_runs([g for g in range(groups) if folds == 1 or g % folds != fold])
        model, gains = likelihood.fit(fit.model, named, part, 5).model, fit.model.gains.copy()
        # how a robot differs is not known where all of its runs are held out
        known = np.unique(part.robot)
        gains[:] = model.gains[known].mean(axis=0)
        gains[known] = model.gains[known]
        models.append(dataclasses.replace(model, gains=gains))
        progress(f"fitted without part {fold + 1} of {folds}")
    return tuple(models[g % folds] for g in range(groups))


def _causes(likelihood: DriveLikelihood, found: Levelled, parts: Sequence[Model]) -> tuple[Cause, ...]:
    """Describe the named effects."""
    data, named = likelihood.data, list(found.evidence)
    coarse = likelihood.fit(found.fit.model, named, data.thinned(), 6).model
    intervals = Intervals(found.fit, data, parts, coarse, found.levels)
    causes = []
    for name, evidence in found.evidence.items():
        numbers: dict[str, Estimate]
        if name == ROBOT_SPREAD:
            numbers, sentence = spread_estimates(found.fit, data.robots, len(found.levels)), SPREAD.sentence
        else:
            numbers, sentence = intervals.estimates(BY_NAME[name]), BY_NAME[name].sentence
        explanation = sentence.format(**{key: number.estimate for key, number in numbers.items()})
        causes.append(Cause(name, numbers, evidence.heldout_gain, evidence.p_value, explanation))
    return tuple(causes)

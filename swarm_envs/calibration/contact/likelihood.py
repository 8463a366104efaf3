"""The likelihood of where robots end up that touch each other or a wall, by the simulation itself."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.contact.candidates import BY_NAME, EFFECTS, ContactModel
from swarm_envs.calibration.contact.windows import TICK, Windows
from swarm_envs.calibration.logs.log import Log
from swarm_envs.calibration.prediction.arena import OPEN_FLOOR
from swarm_envs.calibration.selection.causes import Estimate
from swarm_envs.calibration.selection.cross_validation import cross_validated_gain
from swarm_envs.calibration.selection.likelihood import Fitted, Trial
from swarm_envs.calibration.selection.line_search import line_search
from swarm_envs.calibration.selection.one_number import OneNumberEffects
from swarm_envs.calibration.selection.profile import profile_likelihood_bound
from swarm_envs.simulation import Simulation
from swarm_envs.worlds import WorldSpec

TAIL = 3.0
"""Degrees of freedom of the errors' t distribution: after a contact a small error of a start grows large at times."""
FOLDS = 2
"""Parts of the runs, each held out once."""


class ContactLikelihood(OneNumberEffects[ContactModel]):
    """The likelihood of a log's contacts; models are fitted by searching one number after the other.

    Args:
        log: The log.
        world: What it is compared with, with the drive's named effects.
        windows: The log's windows in which something may touch.
    """

    def __init__(self, log: Log, world: WorldSpec, windows: Windows) -> None:
        super().__init__(ContactModel.of(world), EFFECTS)
        arena = dataclasses.replace(world.arena, outline=log.outline or OPEN_FLOOR, obstacles=())
        certain = world.with_effects(
            command_loss=0.0, start_kick_mean=0.0, start_kick_sd=0.0, linear_gain_spread=0.0, angular_gain_spread=0.0
        )
        self.world = certain.replace(arena=arena, objects=(), tick=TICK).with_robots(windows.start.shape[1])
        self.windows = windows
        self.runs: list[float] = np.unique(windows.run).tolist()
        self.known: dict[ContactModel, FloatArray] = {}

    # the likelihood

    def errors(self, model: ContactModel) -> FloatArray:
        """Return the errors (W, R, 3) of the simulation's end poses."""
        model = model.rounded()
        if model not in self.known:
            simulation = Simulation(model.acting_in(self.world), len(self.windows.start), engine="disc")
            simulation.poses[:] = self.windows.start
            for commands in self.windows.commands:
                simulation.step(commands)
            errors = simulation.poses - self.windows.end
            errors[..., 2] = (errors[..., 2] + np.pi) % (2 * np.pi) - np.pi
            self.known[model] = errors
        return self.known[model]

    def kept(self, model: ContactModel, runs: Sequence[float] | None) -> FloatArray:
        """Return the errors (N, 3) of robots near something."""
        chosen = self.windows.near > 0.5
        if runs is not None:
            chosen = chosen & np.isin(self.windows.run, runs)[:, None]
        return self.errors(model)[chosen]

    def log_likelihood(self, model: ContactModel, runs: Sequence[float] | None = None, scale: FloatArray | None = None) -> float:
        """Return the log-likelihood of the end poses of robots near something, the errors' scale being the likeliest unless given."""
        errors = self.kept(model, runs)
        scale = likeliest_scale(errors) if scale is None else scale
        shape = np.log1p((errors / scale) ** 2 / TAIL)
        return float(-np.sum(0.5 * (TAIL + 1) * shape) - len(errors) * np.sum(np.log(scale)))

    # fits

    def grid_search(self, model: ContactModel, name: str) -> ContactModel:
        """Return the model with one number at the best of its grid."""
        effect = BY_NAME[name]
        unit = self.base.value(name) if effect.relative else 1.0
        trials = [model, *(model.with_value(name, value * unit) for value in effect.grid)]
        return trials[int(np.argmax([self.log_likelihood(trial) for trial in trials]))]

    def fit(self, model: ContactModel, names: Sequence[str], runs: Sequence[float] | None = None) -> Fitted[ContactModel]:
        """Improve some numbers one after the other."""
        for name in names:
            now = model.value(name)
            reach, tolerance = (0.04 * now, 0.002) if BY_NAME[name].relative else (max(0.06, 0.3 * now), 0.02)

            def value_at(value: float, name: str = name, model: ContactModel = model) -> float:
                return self.log_likelihood(model.with_value(name, value), runs)

            value, _ = line_search(value_at, now, value_at(now), (max(0.0, now - reach), now + reach), tolerance * reach, 14)
            model = model.with_value(name, value)
        return Fitted(model, self.log_likelihood(model, runs))

    # what forward selection asks

    def propose(self, fit: Fitted[ContactModel], named: Sequence[str], candidates: Sequence[str]) -> list[Trial[ContactModel]]:
        """Add each candidate: a grid search, then a fit of it alone."""
        fits = {name: self.fit(self.grid_search(fit.model, name), [name]) for name in candidates}
        return [Trial(name, found.model, found.log_likelihood - fit.log_likelihood) for name, found in fits.items()]

    def refit(self, model: ContactModel, named: Sequence[str]) -> Fitted[ContactModel]:
        """Fit all named numbers."""
        return self.fit(model, named)

    def heldout_gain(self, fit: Fitted[ContactModel], named: Sequence[str], trial: Trial[ContactModel]) -> float:
        """Return what a number gains on runs that it was not fitted to; of a single run, on that."""
        if len(self.runs) < FOLDS:
            return trial.gain

        def gained(train: list[int], test: list[int]) -> float:
            fitted_to, held_out = ([self.runs[k] for k in part] for part in (train, test))
            after = self.fit(trial.model, [trial.name], fitted_to).model
            values = [self.log_likelihood(model, held_out, likeliest_scale(self.kept(model, fitted_to))) for model in (fit.model, after)]
            return values[1] - values[0]

        return cross_validated_gain(len(self.runs), FOLDS, gained)

    # what is found

    def estimate(self, fit: Fitted[ContactModel], named: Sequence[str], name: str) -> Estimate:
        """Return a named number with the interval that the profile of the likelihood gives."""
        effect, value = BY_NAME[name], fit.model.value(name)
        best = self.log_likelihood(fit.model)

        def drop(trial: float) -> float:
            return best - self.log_likelihood(fit.model.with_value(name, trial))

        reach = 0.1 * value if effect.relative else max(0.2, 0.7 * value)
        margin = 0.2 * effect.minimum_effect
        low = profile_likelihood_bound(drop, value, max(0.0, value - reach)) - margin
        return Estimate(value, (max(0.0, low), profile_likelihood_bound(drop, value, value + reach) + margin), effect.unit)


def likeliest_scale(errors: FloatArray) -> FloatArray:
    """Return the likeliest scale (3,) of errors (N, 3), one for both coordinates."""
    scale = np.maximum(np.median(np.abs(errors), axis=0), 1e-6)
    for _ in range(20):
        squares = np.mean((TAIL + 1) * errors**2 / (TAIL + (errors / scale) ** 2), axis=0)
        squares[:2] = squares[:2].mean()
        scale = np.sqrt(np.maximum(squares, 1e-12))
    return np.asarray(scale)

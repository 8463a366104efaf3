"""The likelihood of a log's poses under a drive, as forward selection asks for it."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.drive.candidates import BY_NAME, DRIVE_CANDIDATES, Candidate
from swarm_envs.calibration.drive.fitting import NOISE_FREE, Fit, Free, Model, block_sums, free, free_gains, maximise
from swarm_envs.calibration.drive.line_searches import likeliest_loss, likeliest_threshold
from swarm_envs.calibration.drive.measured import Measured
from swarm_envs.calibration.drive.noise import ALONG
from swarm_envs.calibration.drive.robot_spread import ROBOT_SPREAD, spread_of
from swarm_envs.calibration.selection.cross_validation import cross_validated_gain
from swarm_envs.calibration.selection.likelihood import Trial

SHORTLIST = 4
"""Candidates of a round that are fitted together with the noise; the others are only scanned."""
FOLDS = 4
"""Parts of the runs, each held out once."""
WORTH_REFINING = 2.0
"""Gain in log-likelihood over which a candidate on the shortlist is fitted together with the noise."""
WORTH_A_SECOND_START = 50.0
"""Gain over which the two best are, a second time, from the first guess of the noise."""
CERTAIN = 200.0
"""Gain in log-likelihood from which overdispersion cannot make a candidate doubtful."""
LEAST_SPREAD = 0.01
"""Robots whose factors differ by less from one do not differ."""
STEPLESS = ("deadband", "command_loss")
"""Effects along whose parameters the likelihood has no slopes."""


class DriveLikelihood:
    """The likelihood of a log's poses; models are fitted by Fisher scoring.

    Args:
        data: The log.
        base: (P,) the drive's parameters that a dropped effect goes back to.
        noise: (5,) first guess of the noise.
    """

    def __init__(self, data: Measured, base: FloatArray, noise: FloatArray) -> None:
        self.data, self.base, self.first_noise = data, base, noise
        # the tracker's noise shows where nothing moves; left alone it may vanish into that of the motion
        floors = np.log(0.5 * noise[:ALONG])
        self.noise = tuple(dataclasses.replace(entry, low=floors[k]) if k < ALONG else entry for k, entry in enumerate(NOISE_FREE))

    # fits

    def free_entries(self, names: Sequence[str]) -> list[Free]:
        """Return what is fitted with some effects named: their smooth parameters, the robots' factors, the noise."""
        entries: list[Free] = []
        for name in names:
            if name == ROBOT_SPREAD:
                entries += free_gains(len(self.data.robots))
            elif BY_NAME[name].smooth and name != "command_loss":
                entries += free(BY_NAME[name].parameters)
        if ROBOT_SPREAD in names:
            # the robots' own factors hold both gains' levels
            gains = {p.index for name in ("linear_gain", "angular_gain") for p in BY_NAME[name].parameters}
            entries = [entry for entry in entries if entry.index not in gains]
        return [*entries, *self.noise]

    def fit(self, model: Model, names: Sequence[str], data: Measured, iterations: int = 12, *, noise: bool = True) -> Fit:
        """Fit some effects and, unless it is left as it is, the noise."""
        what = [entry for entry in self.free_entries(names) if noise or entry not in self.noise]
        for _ in range(2 if any(name in names for name in STEPLESS) else 1):
            fitted = maximise(model, what, data, iterations)
            model = fitted.model
            if "deadband" in names:
                model = likeliest_threshold(model, data)
            if "command_loss" in names:
                model = likeliest_loss(model, data)
        if model is not fitted.model:
            fitted = maximise(model, what, data, 2)
        return fitted

    def fit_noise(self, model: Model) -> Fit:
        """Fit the noise alone."""
        return maximise(model, self.noise, self.data, 30)

    def scan(self, fit: Fit, candidate: Candidate) -> tuple[Model, float]:
        """Fit a candidate with the noise as it is, from the best of its starts; returns the log-likelihood, too."""
        model = fit.model
        starts = [model.with_values(candidate.parameters, values) for values in candidate.starts(model.parameters, self.data)]
        if not starts:
            return model, -np.inf
        values = [start.filtered(self.data).total for start in starts]
        best = starts[int(np.argmax(values))]
        if not candidate.smooth:
            best = likeliest_threshold(best, self.data)
            return best, best.filtered(self.data).total
        if candidate.name == "command_loss":
            return best, max(values)
        fitted = maximise(best, free(candidate.parameters), self.data, 6)
        return fitted.model, fitted.log_likelihood

    def refine(self, model: Model, named: Sequence[str], name: str, *, again: bool) -> Fit:
        """Fit a candidate together with the named effects and the noise."""
        # noise that explains the log without the candidate may leave it no slope: a second fit begins with the first guess of it
        starts = (model, dataclasses.replace(model, noise=self.first_noise)) if again else (model,)
        fits = [self.fit(start, [*named, name], self.data) for start in starts]
        return max(fits, key=lambda fitted: fitted.log_likelihood)

    # what forward selection asks

    @property
    def candidates(self) -> tuple[str, ...]:
        """Effects that may be named, simplest first."""
        return (*BY_NAME, *([ROBOT_SPREAD] if len(self.data.robots) > 1 else []))

    def confounded_with(self, name: str) -> tuple[str, ...]:
        """Return the effects that no such log can tell from one."""
        return BY_NAME[name].confounded_with if name in BY_NAME else ()

    def numbers(self, name: str) -> int:
        """Return the number of an effect's parameters."""
        return len(BY_NAME[name].parameters) if name in BY_NAME else 1

    def propose(self, fit: Fit, named: Sequence[str], candidates: Sequence[str]) -> list[Trial[Model]]:
        """Scan each candidate, and fit the best together with the noise."""
        scanned = []
        for name in candidates:
            if name != ROBOT_SPREAD:
                model, likelihood = self.scan(fit, BY_NAME[name])
                scanned.append(Trial(name, model, likelihood - fit.log_likelihood, self.numbers(name)))
        scanned.sort(key=lambda trial: -trial.gain)
        trials = []
        for rank, trial in enumerate(scanned):
            if rank < SHORTLIST and trial.gain > WORTH_REFINING:
                again = rank < 2 and trial.gain > WORTH_A_SECOND_START
                refined = self.refine(trial.model, named, trial.name, again=again)
                trial = Trial(trial.name, refined.model, refined.log_likelihood - fit.log_likelihood, trial.numbers)
            trials.append(trial)
        return [*trials, *([self.spread_trial(fit, named)] if ROBOT_SPREAD in candidates else [])]

    def spread_trial(self, fit: Fit, named: Sequence[str]) -> Trial[Model]:
        """Let each robot have its own gains, and weigh that against how much such freedom fits by itself."""
        fitted = self.fit(fit.model, [*named, ROBOT_SPREAD], self.data)
        gain = fitted.log_likelihood - fit.log_likelihood + spread_of(fitted, len(self.data.robots)).evidence
        return Trial(ROBOT_SPREAD, fitted.model, gain, 1)

    def refit(self, model: Model, named: Sequence[str]) -> Fit:
        """Fit all named effects and the noise."""
        return self.fit(model, named, self.data, 20)

    def without(self, fit: Fit, others: Sequence[str], name: str) -> Fit:
        """Fit again with one effect as the world has it."""
        parameters = BY_NAME[name].parameters
        return self.fit(fit.model.with_values(parameters, [float(self.base[p.index]) for p in parameters]), others, self.data)

    def overdispersion(self, fit: Fit, trial: Trial[Model]) -> float:
        """Return how much more the gain varies over blocks than the model expects, at least 1."""
        likelihood = trial.model.filtered(self.data).log_likelihood - fit.model.filtered(self.data).log_likelihood
        blocks = block_sums(likelihood[:, None], self.data)[:, 0]
        # for a right model the variance of a block's log-likelihood ratio is twice its mean
        expected = 2.0 * max(float(blocks.sum()), 1e-9)
        spread = float(np.sum((blocks - blocks.mean()) ** 2))
        return float(np.clip(spread / expected, 1.0, 1e3)) if trial.gain < CERTAIN else 1.0

    def is_large_enough(self, fit: Fit, trial: Trial[Model]) -> bool:
        """Whether an effect is large enough to change what a robot does."""
        if trial.name == ROBOT_SPREAD:
            return bool(np.abs(trial.model.gains - 1.0).max() > LEAST_SPREAD)
        for parameter in BY_NAME[trial.name].parameters:
            before, after = fit.model.parameters[parameter.index], trial.model.parameters[parameter.index]
            unit = max(1.0, abs(before) if np.isfinite(before) else 1.0)
            if not abs(after - before) < parameter.minimum_effect * unit:
                return True
        return False

    def is_negligible(self, fit: Fit, name: str) -> bool:
        """Whether an effect is so near to what the world has that it changes nothing."""
        return all(abs(fit.model.parameters[p.index] - self.base[p.index]) < p.minimum_effect for p in BY_NAME[name].parameters)

    def heldout_gain(self, fit: Fit, named: Sequence[str], trial: Trial[Model]) -> float:
        """Return what a candidate gains on poses that were not fitted, in nats; of a single group, on that.

        The noise stays that of all runs: fitted without the one run that has wild poses, it would make them count for everything.
        """
        if len(self.data.runs) < 2:
            return trial.gain

        def gained(train: list[int], test: list[int]) -> float:
            fitted_to, held_out = self.data.of_runs(train), self.data.of_runs(test)
            before = self.fit(fit.model, named, fitted_to, 3, noise=False).model
            after = self.fit(trial.model, [*named, trial.name], fitted_to, 3, noise=False).model
            return after.filtered(held_out).total - before.filtered(held_out).total

        return cross_validated_gain(len(self.data.runs), FOLDS, gained)


TRIED = len(DRIVE_CANDIDATES)
"""Candidates for which backward elimination is corrected."""

"""Which effects explain a log: greedy selection by likelihood, checked on held-out runs, corrected for the number tried."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.stats import chi2
from scipy.stats import f as f_distribution

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.drive.candidates import BY_NAME, DRIVE_CANDIDATES, Candidate, Parameter, rim_speeds, thresholds
from swarm_envs.calibration.drive.fitting import NOISE_FREE, Fit, Free, Model, block_sums, fit, free, free_gains, inverse
from swarm_envs.calibration.drive.measured import Measured, measured
from swarm_envs.calibration.drive.motion import free_run
from swarm_envs.calibration.drive.noise import ALONG
from swarm_envs.calibration.drive.parameters import INDEX, drive_parameters
from swarm_envs.calibration.logs.log import Log, tracked
from swarm_envs.calibration.selection.causes import CLOSE, SIGNIFICANT, Cause, Estimate
from swarm_envs.calibration.selection.profile import edge
from swarm_envs.worlds import WorldSpec

MOST_EFFECTS = 6
"""At most so many effects are named."""
SHORTLIST = 4
"""Candidates of a round that are fitted together with the noise; the others are only scanned."""
Progress = Callable[[str], None]


@dataclass(frozen=True)
class Identified:
    """What explains the drives of a log."""

    causes: tuple[Cause, ...]
    model: Model
    """The drive with the named effects, and the noise."""
    robots: tuple[str, ...]
    """Names of the robots, in the order of the model's gains."""
    indistinguishable: tuple[tuple[str, ...], ...]
    """Groups of effects that these data cannot tell apart."""
    rejected: tuple[tuple[str, float], ...]
    """Effects tried last and not named, each with its corrected p-value."""
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
class Trial:
    """A candidate added to a model."""

    name: str
    model: Model
    gain: float
    """In log-likelihood over the model without it."""
    numbers: int
    """Parameters that it adds."""


def identify(log: Log, world: WorldSpec, progress: Progress = lambda text: None) -> Identified:
    """Name the effects of the drive that explain a log.

    Args:
        log: The log.
        world: What it is compared with; its own effects are where the search begins.
        progress: Called with a line at each step.

    Raises:
        LogError: When nothing in the log can be predicted.
    """
    return Search(log, world, progress).run()


class Search:
    """State of one identification."""

    def __init__(self, log: Log, world: WorldSpec, progress: Progress) -> None:
        self.data = measured(log)
        self.progress = progress
        robots = len(self.data.robots)
        base = drive_parameters(world)
        self.gains_first = False
        rough = rough_gains(log, base)
        if log.driver_units or any(not 0.05 < ratio < 20.0 for ratio in rough if np.isfinite(ratio)):
            self.gains_first = True
            base[INDEX["linear_gain"]] *= rough[0] if np.isfinite(rough[0]) else 1.0
            base[INDEX["angular_gain"]] *= rough[1] if np.isfinite(rough[1]) else 1.0
        self.base = base
        self.named: list[str] = []
        self.records: dict[str, tuple[float, float]] = {}
        self.groups: list[tuple[str, ...]] = []
        self.levels: dict[str, float] = {}
        self.parts: tuple[Model, ...] = ()
        self.coarse: Model | None = None
        first = ["linear_gain"] * bool(np.isfinite(rough[0])) + ["angular_gain"] * bool(np.isfinite(rough[1]))
        noise = self.rough = rough_noise(self.data)
        # the tracker's noise shows where nothing moves; left alone it may vanish into that of the motion
        floors = np.log(0.5 * noise[:ALONG])
        self.noise = tuple(dataclasses.replace(entry, low=floors[k]) if k < ALONG else entry for k, entry in enumerate(NOISE_FREE))
        start = Model(base, noise, np.ones((robots, 2)))
        self.start = dataclasses.replace(start, parameters=drive_parameters(world))
        self.fit = fit(start, self.noise, self.data, 30)
        if self.gains_first:
            self.named = first
            self.records = {name: (float("nan"), 0.0) for name in first}
            self.fit = self.refit(self.fit.model)

    def run(self) -> Identified:
        """Add effects while they are real."""
        rejected: tuple[tuple[str, float], ...] = ()
        while len(self.named) < MOST_EFFECTS + 2 * self.gains_first:
            trials = self.trials()
            rejected = tuple((trial.name, self.p_value(trial, len(trials))) for trial in trials)
            accepted = next((trial for trial in trials[:3] if self.accept(trial, len(trials))), None)
            if accepted is None:
                break
            close = [t.name for t in trials if t.name != accepted.name and self.merit(accepted) - self.merit(t) < CLOSE]
            if close:
                self.groups.append((accepted.name, *close))
            self.named.append(accepted.name)
            self.fit = self.refit(accepted.model)
            self.drop_idle()
        return self.result(rejected)

    # the candidates of a round

    def trials(self) -> list[Trial]:
        """Fit every candidate that is not in yet, the best first."""
        scanned: list[tuple[float, Candidate, Model]] = []
        for candidate in DRIVE_CANDIDATES:
            if candidate.name in self.named or any(other in self.named for other in candidate.confounded_with):
                continue
            model, likelihood = self.scan(candidate)
            scanned.append((likelihood - self.fit.log_likelihood, candidate, model))
        scanned.sort(key=lambda entry: -entry[0])
        trials = []
        for rank, (gain, candidate, model) in enumerate(scanned):
            if rank < SHORTLIST and gain > 2.0:
                fitted = self.polish(candidate, model, again=rank < 2 and gain > 50.0)
                model, gain = fitted.model, fitted.log_likelihood - self.fit.log_likelihood
            trials.append(Trial(candidate.name, model, gain, len(candidate.parameters)))
        if len(self.data.robots) > 1 and "robot_spread" not in self.named:
            trials.append(self.spread_trial())
        self.progress(", ".join(f"{t.name} {t.gain:.1f}" for t in sorted(trials, key=self.merit, reverse=True)[:4]))
        return sorted(trials, key=self.merit, reverse=True)

    @staticmethod
    def merit(trial: Trial) -> float:
        """Gain in log-likelihood less what its parameters would gain by chance."""
        return trial.gain - 2.0 * trial.numbers

    def scan(self, candidate: Candidate) -> tuple[Model, float]:
        """Fit a candidate with the noise as it is, from the best of its starts."""
        model = self.fit.model
        starts = [model.with_values(candidate.parameters, values) for values in candidate.starts(model.parameters, self.data)]
        if not starts:
            return model, -np.inf
        values = [start.filtered(self.data).total for start in starts]
        best = starts[int(np.argmax(values))]
        if not candidate.smooth:
            best = best_threshold(best, self.data)
            return best, best.filtered(self.data).total
        if candidate.name == "command_loss":
            return best, max(values)
        fitted = fit(best, free(candidate.parameters), self.data, 6)
        return fitted.model, fitted.log_likelihood

    def polish(self, candidate: Candidate, model: Model, *, again: bool) -> Fit:
        """Fit a candidate together with the named effects and the noise."""
        names = [*self.named, candidate.name]
        # noise that explains the log without the candidate may leave it no slope: a second climb begins with the first guess of it
        starts = (model, dataclasses.replace(model, noise=self.rough)) if again else (model,)
        fits = [self.climb(start, names, self.data) for start in starts]
        return max(fits, key=lambda fitted: fitted.log_likelihood)

    def climb(self, model: Model, names: list[str], data: Measured, iterations: int = 12, *, noise: bool = True) -> Fit:
        """Fit some effects and, unless it is left as it is, the noise."""
        what = [entry for entry in self.what(names) if noise or entry not in self.noise]
        for _ in range(2 if "deadband" in names or "command_loss" in names else 1):
            fitted = fit(model, what, data, iterations)
            model = fitted.model
            if "deadband" in names:
                model = best_threshold(model, data)
            if "command_loss" in names:
                model = best_loss(model, data)
        if model is not fitted.model:
            fitted = fit(model, what, data, 2)
        return fitted

    def what(self, names: list[str]) -> list[Free]:
        """Return what is fitted with some effects named: their smooth parameters, the robots' factors, the noise."""
        entries: list[Free] = []
        for name in names:
            if name == "robot_spread":
                entries += free_gains(len(self.data.robots))
            elif BY_NAME[name].smooth and name != "command_loss":
                entries += free(BY_NAME[name].parameters)
        if "robot_spread" in names:
            # the robots' own factors hold both gains' levels
            gains = {p.index for name in ("linear_gain", "angular_gain") for p in BY_NAME[name].parameters}
            entries = [entry for entry in entries if entry.index not in gains]
        return [*entries, *self.noise]

    def refit(self, model: Model) -> Fit:
        """Fit all named effects and the noise."""
        return self.climb(model, self.named, self.data, 20)

    def spread_trial(self) -> Trial:
        """Let each robot have its own gains, and weigh that against how much such freedom fits by itself."""
        robots = len(self.data.robots)
        fitted = self.climb(self.fit.model, [*self.named, "robot_spread"], self.data)
        entries = [k for k, entry in enumerate(fitted.fitted) if entry in free_gains(robots)]
        factors = fitted.model.gains.ravel()
        spread = factors_spread(factors, inverse(fitted.fisher)[np.ix_(entries, entries)])
        gain = fitted.log_likelihood - self.fit.log_likelihood + spread.evidence
        return Trial("robot_spread", fitted.model, gain, 1)

    # is it real?

    def p_value(self, trial: Trial, tried: int) -> float:
        """Return the p-value of a likelihood ratio, widened where residuals are not as independent as the model has them."""
        inflation = self.inflation(trial)
        return float(min(1.0, tried * chi2.sf(2.0 * max(trial.gain, 0.0) / inflation, trial.numbers)))

    def inflation(self, trial: Trial) -> float:
        """Return how much more the score varies over blocks than the model expects, at least 1."""
        likelihood = trial.model.filtered(self.data).log_likelihood - self.fit.model.filtered(self.data).log_likelihood
        blocks = block_sums(likelihood[:, None], self.data)[:, 0]
        # for a right model the variance of a block's log-likelihood ratio is twice its mean
        expected = 2.0 * max(float(blocks.sum()), 1e-9)
        spread = float(np.sum((blocks - blocks.mean()) ** 2))
        return float(np.clip(spread / expected, 1.0, 1e3)) if trial.gain < 200.0 else 1.0

    def accept(self, trial: Trial, tried: int) -> bool:
        """Whether an effect is real: significant, and better on runs that were held out."""
        p = self.p_value(trial, tried)
        if p > SIGNIFICANT or not self.matters(trial):
            return False
        held_out = self.heldout(trial)
        self.progress(f"{trial.name}: gain {trial.gain:.1f}, p {p:.2g}, held out {held_out:.1f}")
        if held_out <= 0.0:
            return False
        self.records[trial.name] = (held_out, p)
        return True

    def matters(self, trial: Trial) -> bool:
        """Whether an effect is large enough to change what a robot does."""
        if trial.name == "robot_spread":
            return bool(np.abs(trial.model.gains - 1.0).max() > 0.01)
        before, after = self.fit.model.parameters, trial.model.parameters
        return any(
            not abs(after[p.index] - before[p.index])
            < p.minimum_effect * max(1.0, abs(before[p.index]) if np.isfinite(before[p.index]) else 1.0)
            for p in BY_NAME[trial.name].parameters
        )

    def heldout(self, trial: Trial, folds: int = 4) -> float:
        """Return what a candidate gains on poses that were not fitted, in nats.

        The noise stays that of all runs: fitted without the one run that has wild poses, it would make them count for everything.
        """
        groups = len(self.data.runs)
        if groups < 2:
            return trial.gain
        total = 0.0
        for fold in range(min(folds, groups)):
            out = [g for g in range(groups) if g % min(folds, groups) == fold]
            train, test = self.data.of_runs([g for g in range(groups) if g not in out]), self.data.of_runs(out)
            before = self.climb(self.fit.model, self.named, train, 3, noise=False).model
            after = self.climb(trial.model, [*self.named, trial.name], train, 3, noise=False).model
            total += after.filtered(test).total - before.filtered(test).total
        return total

    def drop_idle(self) -> None:
        """Take out an effect that a later one has made unnecessary."""
        for name in list(self.named):
            if name == "robot_spread" or (self.gains_first and name in ("linear_gain", "angular_gain")):
                continue
            candidate = BY_NAME[name]
            neutral = [float(self.base[p.index]) for p in candidate.parameters]
            others = [other for other in self.named if other != name]
            idle = all(abs(self.fit.model.parameters[p.index] - self.base[p.index]) < p.minimum_effect for p in candidate.parameters)
            if name == self.named[-1] and not idle:
                continue
            without = self.climb(self.fit.model.with_values(candidate.parameters, neutral), others, self.data)
            lost = self.fit.log_likelihood - without.log_likelihood
            if idle or chi2.sf(2 * max(lost, 0.0), len(candidate.parameters)) * len(DRIVE_CANDIDATES) > SIGNIFICANT:
                self.progress(f"{name} is no longer needed")
                self.named, self.fit = others, without

    # the answer

    def result(self, rejected: tuple[tuple[str, float], ...]) -> Identified:
        """Say what was found."""
        if "robot_spread" in self.named:
            self.level_gains()
        confounded = [(name, *BY_NAME[name].confounded_with) for name in self.named if name in BY_NAME and BY_NAME[name].confounded_with]
        groups = [*self.groups, *confounded]
        if self.named:
            self.parts = self.leave_out()
            self.coarse = self.climb(self.fit.model, self.named, self.data.thinned(), 6).model
        causes = tuple(self.cause(name) for name in self.named)
        return Identified(
            causes, self.fit.model, self.data.robots, tuple(groups), rejected, self.gains_first, self.data, self.start,
            lambda: self.parts or self.leave_out(),
        )  # fmt: skip

    def leave_out(self) -> tuple[Model, ...]:
        """Return for each group the model with the named effects, fitted without the group's fold."""
        groups = len(self.data.runs)
        folds = min(6, groups)
        models: list[Model] = []
        for fold in range(folds):
            train = [g for g in range(groups) if folds == 1 or g % folds != fold]
            part = self.data.of_runs(train)
            model, gains = self.climb(self.fit.model, self.named, part, 5).model, self.fit.model.gains.copy()
            # of a robot that is only in what is held out nobody knows how it differs
            known = np.unique(part.robot)
            gains[:] = model.gains[known].mean(axis=0)
            gains[known] = model.gains[known]
            models.append(dataclasses.replace(model, gains=gains))
            self.progress(f"fitted without part {fold + 1} of {folds}")
        return tuple(models[g % folds] for g in range(groups))

    def cause(self, name: str) -> Cause:
        """Describe a named effect."""
        gain, p = self.records[name]
        numbers = self.spread_estimates() if name == "robot_spread" else self.estimates(BY_NAME[name])
        sentence = "Robots differ: their gains vary by {sd:.3g} of their value." if name == "robot_spread" else BY_NAME[name].sentence
        return Cause(name, numbers, gain, p, sentence.format(**{key: value.estimate for key, value in numbers.items()}))

    def estimates(self, candidate: Candidate) -> dict[str, Estimate]:
        """Return an effect's numbers with their intervals, the wider of what the model and what the residuals say."""
        covariance, robust = self.fit.covariance, self.fit.robust_variance(self.data)
        found = {}
        for parameter in candidate.parameters:
            value = float(self.fit.model.parameters[parameter.index])
            place = next((k for k, entry in enumerate(self.fit.fitted) if entry.index == parameter.index), None)
            if candidate.name in self.levels:
                # robots differ: a few of them leave open what a fleet of them would do on average
                half = self.levels[candidate.name] * value
                found[parameter.name] = Estimate(value, (value - half, value + half), parameter.unit)
            elif place is None:
                found[parameter.name] = Estimate(value, self.profile(candidate, parameter, value), parameter.unit)
            else:
                blur = (0.05 * parameter.minimum_effect) ** 2
                half = 1.96 * float(np.sqrt(max(covariance[place, place], robust[place], self.unsteadiness(parameter)) + blur))
                found[parameter.name] = Estimate(
                    value, (max(parameter.low, value - half), min(parameter.high, value + half)), parameter.unit
                )
        return found

    def unsteadiness(self, parameter: Parameter) -> float:
        """Return the variance of an estimate by how it moves when parts of the runs, or every second pose, are left out.

        Where a model is right the poses left out move an estimate less than chance does; where it is wrong, as one delay for all that
        is late, the answer depends on how often one looks.
        """
        models = {id(model): model for model in self.parts}
        moved = np.array([model.parameters[parameter.index] for model in models.values()])
        jackknife = float((len(moved) - 1) * np.var(moved)) if len(moved) >= 3 else 0.0
        shift = 0.0 if self.coarse is None else self.coarse.parameters[parameter.index] - self.fit.model.parameters[parameter.index]
        return max(jackknife, float(shift) ** 2)

    def profile(self, candidate: Candidate, parameter: Parameter, value: float) -> tuple[float, float]:
        """Return the values whose likelihood is within 1.92 of the best, the rest as fitted."""

        def drop(trial: float) -> float:
            return self.fit.log_likelihood - self.fit.model.with_values([parameter], [trial]).filtered(self.data).total

        if candidate.name == "deadband":
            speeds, every = rim_speeds(self.fit.model.parameters, self.data), thresholds(self.fit.model.parameters, self.data)
            near = int(np.searchsorted(every, value))
            inside = [float(v) for v in every[max(0, near - 40) : near + 40] if drop(float(v)) < 1.92] or [value]
            return float(speeds[speeds < min(inside)].max(initial=0.0)), float(speeds[speeds > max(inside)].min(initial=parameter.high))
        return edge(drop, value, parameter.low), edge(drop, value, parameter.high)

    def level_gains(self) -> None:
        """Take out of the robots' own factors what all have in common, and name it where chance would not give robots such a mean."""
        factors = self.fit.model.gains - 1.0
        count = len(factors)
        for column, name in enumerate(("linear_gain", "angular_gain")):
            about = [float(np.sum((factors[:, k] - factors[:, k].mean()) ** 2)) for k in range(2)]
            other = about[1 - column] if self.level_named(1 - column) else float(np.sum(factors[:, 1 - column] ** 2))
            left = about[column] + other
            ratio = count * float(factors[:, column].mean()) ** 2 / max(left / (2 * count - 1), 1e-12)
            p = min(1.0, 2.0 * float(f_distribution.sf(ratio, 1, 2 * count - 1)))
            if name in self.named or (p < SIGNIFICANT and abs(factors[:, column].mean()) > BY_NAME[name].parameters[0].minimum_effect):
                if name not in self.named:
                    self.named.append(name)
                    self.records[name] = (0.5 * (2 * count) * float(np.log1p(ratio / (2 * count - 1))), p)
                level = float(self.fit.model.gains[:, column].mean())
                parameters, gains = self.fit.model.parameters.copy(), self.fit.model.gains.copy()
                parameters[BY_NAME[name].parameters[0].index] *= level
                gains[:, column] /= level
                self.fit = dataclasses.replace(self.fit, model=dataclasses.replace(self.fit.model, parameters=parameters, gains=gains))
                self.levels[name] = 1.96 * float(np.sqrt(left / (2 * count - 1) / count)) / level

    def level_named(self, column: int) -> bool:
        """Whether a gain that all robots have in common is named."""
        return ("linear_gain", "angular_gain")[column] in self.named

    def spread_estimates(self) -> dict[str, Estimate]:
        """Return how much robots differ, and each one's factors."""
        robots = len(self.data.robots)
        entries = [k for k, entry in enumerate(self.fit.fitted) if entry in free_gains(robots)]
        covariance = inverse(self.fit.fisher)[np.ix_(entries, entries)]
        spread = factors_spread(self.fit.model.gains.ravel(), covariance)
        freedom = 2 * robots - len(self.levels)
        exact = spread.sd * np.sqrt(2 * robots / chi2.ppf((0.975, 0.025), freedom))
        interval = (min(spread.ci95[0], float(exact[0])), max(spread.ci95[1], float(exact[1])))
        found = {"sd": Estimate(spread.sd * float(np.sqrt(2 * robots / freedom)), interval, "1")}
        for k, robot in enumerate(self.data.robots):
            for j, name in enumerate(("linear", "angular")):
                value, half = float(self.fit.model.gains[k, j]), 1.96 * float(np.sqrt(covariance[2 * k + j, 2 * k + j]))
                found[f"{robot}.{name}_gain"] = Estimate(value, (value - half, value + half), "1")
        return found


def best_threshold(model: Model, data: Measured) -> Model:
    """Return the model with the likeliest deadband: the best of some thresholds, then of all near it."""
    parameter = BY_NAME["deadband"].parameters
    every = thresholds(model.parameters, data)
    if not len(every):
        return model
    stride = max(1, len(every) // 40)
    best, likelihood = model, model.filtered(data).total
    near = int(np.searchsorted(every, model.parameters[parameter[0].index]))
    for places in (range(0, len(every), stride), None):
        for place in places if places is not None else range(max(0, near - stride), min(len(every), near + stride + 1)):
            trial = model.with_values(parameter, [float(every[place])])
            total = trial.filtered(data).total
            if total > likelihood:
                best, likelihood, near = trial, total, place
    return best


def best_loss(model: Model, data: Measured) -> Model:
    """Return the model with the likeliest probability of a lost command."""
    parameter = BY_NAME["command_loss"].parameters

    def drop(logit: float) -> float:
        return -model.with_values(parameter, [1 / (1 + np.exp(-logit))]).filtered(data).total

    logit = float(minimize_scalar(drop, bounds=(-7.0, 2.0), method="bounded", options={"xatol": 0.02}).x)
    return model.with_values(parameter, [1 / (1 + np.exp(-logit))])


@dataclass(frozen=True)
class Spread:
    """How robots' factors on their gains scatter around one."""

    sd: float
    ci95: tuple[float, float]
    evidence: float
    """Log of the likelihood when the factors are drawn with this sd, less that of the best factors."""


def factors_spread(factors: FloatArray, covariance: FloatArray) -> Spread:
    """Return the likeliest standard deviation of factors known with some covariance.

    Args:
        factors: (K,) estimates.
        covariance: (K, K) of the estimates.
    """
    values, vectors = np.linalg.eigh(covariance)
    values = np.maximum(values, 1e-14)
    shift = vectors.T @ (factors - 1.0)

    def loss(log_sd: float) -> float:
        total = values + np.exp(2 * log_sd)
        return float(0.5 * np.sum(shift**2 / total + np.log(total)))

    grid = np.linspace(np.log(1e-5), np.log(2.0), 400)
    losses = np.array([loss(value) for value in grid])
    best = int(np.argmin(losses))
    inside = grid[losses < losses[best] + 1.92]
    # the normalising constant of the estimates' own density
    evidence = -float(losses[best]) + 0.5 * float(np.sum(np.log(values)))
    return Spread(float(np.exp(grid[best])), (float(np.exp(inside[0])), float(np.exp(inside[-1]))), evidence)


def rough_gains(log: Log, base: FloatArray) -> tuple[float, float]:
    """Return the ratios of measured to predicted motion over one second, forward and turning; NaN where none was commanded."""
    driven: list[tuple[FloatArray, FloatArray]] = []
    for track in tracked(log):
        path = free_run(base, track).path
        last = np.searchsorted(track.times, track.times + 1.0)
        first = np.flatnonzero(last < len(track.times))[::10]
        last = last[first]
        gone = track.poses[last, :2] - track.poses[first, :2]
        heading = 0.5 * (track.poses[first, 2] + track.poses[last, 2])
        ahead = gone[:, 0] * np.cos(heading) + gone[:, 1] * np.sin(heading)
        asked = path[last, :2] - path[first, :2]
        way = 0.5 * (path[first, 2] + path[last, 2])
        wanted = asked[:, 0] * np.cos(way) + asked[:, 1] * np.sin(way)
        turns = np.column_stack([path[last, 2] - path[first, 2], track.poses[last, 2] - track.poses[first, 2]])
        driven.append((np.column_stack([wanted, ahead]), turns))
    ratios = []
    for pairs in (np.concatenate([d for d, _ in driven]), np.concatenate([t for _, t in driven])):
        asked, done = pairs.T
        large = np.abs(asked) > 0.5 * np.abs(asked).max(initial=0.0)
        ratios.append(float(np.median(done[large] / asked[large])) if large.sum() > 3 and np.abs(asked).max() > 1e-6 else float("nan"))
    return ratios[0], ratios[1]


def rough_noise(data: Measured) -> FloatArray:
    """Return a first guess of the noise (5,) from third differences, which smooth motion hardly has."""
    thirds = np.diff(data.poses, 3, axis=0)
    sd = np.maximum(np.median(np.abs(thirds), axis=0) / 0.6745 / np.sqrt(20.0), (1e-5, 1e-5, 1e-4))
    return np.array([max(sd[0], sd[1]), sd[2], 3e-3, 2e-3, 3e-2])


__all__ = ["Cause", "Estimate", "Identified", "Search", "identify"]

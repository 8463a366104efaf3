"""The likelihood of a log's readings under a sensor, given where the robots were.

A reading tells whether another robot's disc met the sensor's sector. The noise of measured poses widens the sector's edges; misses and
false detections are chance. The likelihood of all readings then says which numbers of the sensor explain them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from scipy.special import ndtr

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.drive.noise import HEADING, PLACE
from swarm_envs.calibration.selection.causes import Estimate
from swarm_envs.calibration.selection.cross_validation import cross_validated_gain
from swarm_envs.calibration.selection.likelihood import Fitted, Trial
from swarm_envs.calibration.selection.line_search import line_search
from swarm_envs.calibration.selection.one_number import OneNumberEffects
from swarm_envs.calibration.selection.profile import profile_likelihood_bound
from swarm_envs.calibration.sensor.candidates import BY_NAME, EFFECTS, NOISE_SCALE, SensorModel
from swarm_envs.calibration.sensor.error_probabilities import false_detection_probability, miss_probabilities
from swarm_envs.calibration.sensor.views import GRID, Readings, Views
from swarm_envs.simulation.effect_rows import effect_rows
from swarm_envs.worlds import Effects, WorldSpec

SURPRISE = 2e-3
"""Probability of a reading that nothing in the model allows."""
ENOUGH_GAIN = 0.05
"""Gain in log-likelihood under which a fit ends."""
LEAST_PLACE, LEAST_HEADING = 5e-4, 1e-3
"""Noise of the tracker in m and rad that is assumed at least."""
FOLDS = 2
"""Parts of the runs, each held out once."""
MISSES = ("missed_detections", "false_detections", "misses_when_turning")
"""Effects whose numbers are searched from the same few values."""
REACH_SHARE = {"detection_range": 0.15, "field_of_view": 0.15}
"""How far from a number a fit looks for a better one, as a share of the number."""
REACH = {"sensor_yaw": 0.04, "sensor_delay": 0.06}
"""The same of others, in rad and s."""


class SensorLikelihood(OneNumberEffects[SensorModel]):
    """The likelihood of a log's readings; models are fitted by searching one number after the other.

    Args:
        readings: The log's.
        world: Its first robot's first sensor is what the log is compared with.
        noise: (5,) of the log's poses.
    """

    def __init__(self, readings: Readings, world: WorldSpec, noise: FloatArray) -> None:
        super().__init__(SensorModel.of(world), EFFECTS)
        robot = world.robots[0]
        self.readings = readings
        self.listed: Effects = robot.effects
        self.radius = robot.body.visible_radius
        self.bearing = robot.sensors[0].bearing
        self.place, self.heading = max(float(noise[PLACE]), LEAST_PLACE), max(float(noise[HEADING]), LEAST_HEADING)
        self.runs: list[float] = np.unique(readings.views(0.0).run).tolist()

    # the likelihood

    def log_likelihood(self, model: SensorModel, runs: Sequence[float] | None = None) -> float:
        """Return the log-likelihood of all readings, or of those of some runs, in nats."""
        views = self.readings.views(model.sensor_delay)
        near = np.maximum(views.distance, 1e-3)
        inside, effects = self._inside(model, near, views.bearing), self._effects(model)
        seen = 1.0 - np.prod(1.0 - inside, axis=1)
        miss = self._miss(model, effects, views, near, inside)
        report = seen * (1.0 - np.clip(miss, 0.0, 1.0)) + (1.0 - seen) * false_detection_probability(effects)
        report = np.clip(report, SURPRISE, 1.0 - SURPRISE)
        each = np.log(np.where(views.detected, report, 1.0 - report))
        return float(each.sum() if runs is None else each[np.isin(views.run, runs)].sum())

    def _inside(self, model: SensorModel, near: FloatArray, bearing: FloatArray) -> FloatArray:
        """Return the probability (D, O) that each other robot, at these distances in m and bearings in rad, met the sector."""
        scale = np.exp(model.log_noise_scale)
        appears = np.arcsin(np.minimum(1.0, self.radius / near))
        edge_sd = scale * np.sqrt(self.heading**2 + 2.0 * (self.place / near) ** 2)
        off = np.abs((bearing - model.sensor_yaw + np.pi) % (2 * np.pi) - np.pi)
        in_range = ndtr((model.detection_range - near) / (scale * 1.414 * self.place))
        return np.asarray(in_range * ndtr((model.field_of_view + appears - off) / edge_sd))

    def _effects(self, model: SensorModel) -> Sequence[Effects]:
        """Return the robot's effects (1,) with the model's numbers."""
        changed = dataclasses.replace(
            self.listed, missed_detections=model.missed_detections, misses_when_turning=model.misses_when_turning,
            false_detections=model.false_detections,
        )  # fmt: skip
        return effect_rows([changed])

    def _miss(self, model: SensorModel, effects: Sequence[Effects], views: Views, near: FloatArray, inside: FloatArray) -> FloatArray:
        """Return the probability (D,) that each reading misses what was in view."""
        nearest = np.where(inside > 0.5, near, np.inf).min(axis=1)
        share = np.minimum(1.0, np.where(np.isfinite(nearest), nearest, 0.0) / model.detection_range)
        miss = np.empty(len(share))
        miss_probabilities(effects, share, views.driving, views.turning, miss)
        return miss

    # fits

    def fit(self, model: SensorModel, names: Sequence[str], rounds: int = 1, runs: Sequence[float] | None = None) -> Fitted[SensorModel]:
        """Improve some numbers one after the other, for some rounds at most."""
        best = self.log_likelihood(model, runs)
        for _ in range(rounds):
            begun = best
            for name in names:
                value, best = self.refine(model, name, best, runs)
                model = model.with_value(name, value)
            if best - begun < ENOUGH_GAIN:
                break
        return Fitted(model, best)

    def refine(self, model: SensorModel, name: str, best: float, runs: Sequence[float] | None) -> tuple[float, float]:
        """Return the best value of one number near its present one, and the log-likelihood there."""
        now = model.value(name)

        def value_at(value: float) -> float:
            return self.log_likelihood(model.with_value(name, value), runs)

        if name == NOISE_SCALE:
            return line_search(value_at, now, best, (-1.0, 4.0), 0.05)
        reach = REACH_SHARE[name] * now if name in REACH_SHARE else REACH.get(name, max(0.03, 0.7 * now))
        low, high = max(BY_NAME[name].low, now - reach), min(BY_NAME[name].high, now + reach)
        if name != "sensor_delay":
            return line_search(value_at, now, best, (low, high), 1e-4)
        # views are known at the steps of a grid
        places = np.arange(np.ceil(low / GRID), np.floor(high / GRID) + 1) * GRID
        values = [value_at(float(place)) for place in places]
        likeliest = int(np.argmax(values))
        return (float(places[likeliest]), values[likeliest]) if values[likeliest] > best else (now, best)

    def grid_search(self, model: SensorModel, name: str, runs: Sequence[float] | None = None) -> SensorModel:
        """Return the model with one number at the best of a coarse grid over all that it may be."""
        effect, base = BY_NAME[name], self.base.value(name)
        if name in MISSES:
            grid = np.array([0.01, 0.05, 0.15, 0.3, 0.6])
        elif name == "sensor_yaw":
            grid = base + np.linspace(-0.5, 0.5, 41)
        elif name == "sensor_delay":
            grid = np.arange(0.0, 0.9, 0.04)
        else:
            grid = base * np.geomspace(0.2, 4.0, 40)
        inside = grid[(grid >= effect.low) & (grid <= effect.high)]
        trials = [model, *(model.with_value(name, float(value)) for value in inside)]
        return trials[int(np.argmax([self.log_likelihood(trial, runs) for trial in trials]))]

    # what forward selection asks

    def propose(self, fit: Fitted[SensorModel], named: Sequence[str], candidates: Sequence[str]) -> list[Trial[SensorModel]]:
        """Add each candidate: a grid search, then a fit with all that is named."""
        fits = {name: self.fit(self.grid_search(fit.model, name), [*named, name, NOISE_SCALE], 2) for name in candidates}
        return [Trial(name, found.model, found.log_likelihood - fit.log_likelihood) for name, found in fits.items()]

    def refit(self, model: SensorModel, named: Sequence[str]) -> Fitted[SensorModel]:
        """Fit all named effects."""
        return self.fit(model, [*named, NOISE_SCALE], 4)

    def without(self, fit: Fitted[SensorModel], others: Sequence[str], name: str) -> Fitted[SensorModel]:
        """Fit again with one number as the world has it."""
        return self.fit(fit.model.with_value(name, self.base.value(name)), [*others, NOISE_SCALE], 3)

    def heldout_gain(self, fit: Fitted[SensorModel], named: Sequence[str], trial: Trial[SensorModel]) -> float:
        """Return what an effect gains on the runs that it was not fitted to; of a single run, on that."""
        if len(self.runs) < FOLDS:
            return trial.gain

        def gained(train: list[int], test: list[int]) -> float:
            fitted_to, held_out = ([self.runs[k] for k in part] for part in (train, test))
            before = self.fit(fit.model, [*named, NOISE_SCALE], 1, fitted_to).model
            begin = self.grid_search(fit.model, trial.name, fitted_to)
            after = self.fit(begin, [*named, trial.name, NOISE_SCALE], 2, fitted_to).model
            return self.log_likelihood(after, held_out) - self.log_likelihood(before, held_out)

        return cross_validated_gain(len(self.runs), FOLDS, gained)

    # what is found

    def estimate(self, fit: Fitted[SensorModel], named: Sequence[str], name: str) -> Estimate:
        """Return a named effect's number with the interval that the profile of the likelihood gives."""
        effect, model = BY_NAME[name], fit.model
        value, best = model.value(name), self.log_likelihood(model)
        others = [other for other in named if other != name]

        def drop(trial: float) -> float:
            changed = model.with_value(name, trial)
            if name != "sensor_delay" and others:
                # the others follow, so that the interval holds what they leave open
                return best - self.fit(changed, others, 1).log_likelihood
            return best - self.log_likelihood(changed)

        reach = max(0.5 * abs(value), 0.2)
        margin = 0.1 * effect.minimum_effect
        low = profile_likelihood_bound(drop, value, max(effect.low, value - reach)) - margin
        high = profile_likelihood_bound(drop, value, min(effect.high, value + reach)) + margin
        if name == "sensor_delay":
            low, high = low - 0.5 * GRID, high + 0.5 * GRID
        shift = self.bearing if name == "sensor_yaw" else 0.0
        return Estimate(value - shift, (max(effect.low, low - shift), min(effect.high, high - shift)), effect.unit)

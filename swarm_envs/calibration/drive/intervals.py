"""Numbers of the drive's effects with their intervals, the widest of what the model, the residuals and parts of the log say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.drive.candidates import Candidate, Parameter, rim_speeds, thresholds
from swarm_envs.calibration.drive.fitting import Fit, Model
from swarm_envs.calibration.drive.measured import Measured
from swarm_envs.calibration.selection.causes import Estimate
from swarm_envs.calibration.selection.profile import DROP, profile_likelihood_bound

NARROWEST = 0.05
"""No interval has a standard deviation of less than this share of the minimum effect size."""
NEIGHBOURS = 40
"""Thresholds on either side of the likeliest that are looked at."""


@dataclass(frozen=True)
class Intervals:
    """What the intervals of a fit follow from."""

    fit: Fit
    data: Measured
    """What it was fitted to."""
    parts: Sequence[Model]
    """Fits without each part of the runs; those of one part are one object."""
    coarse: Model
    """A fit to every second pose."""
    levels: dict[str, float]
    """By gain that all of the robots that differ have in common, half its interval as a share of it."""

    def estimates(self, candidate: Candidate) -> dict[str, Estimate]:
        """Return an effect's numbers."""
        return {parameter.name: self._estimate(candidate, parameter) for parameter in candidate.parameters}

    def _estimate(self, candidate: Candidate, parameter: Parameter) -> Estimate:
        value = float(self.fit.model.parameters[parameter.index])
        place = next((k for k, entry in enumerate(self.fit.fitted) if entry.index == parameter.index), None)
        if candidate.name in self.levels:
            # robots differ: a few of them leave open what a fleet of them would do on average
            half = self.levels[candidate.name] * value
            return Estimate(value, (value - half, value + half), parameter.unit)
        if place is None:
            return Estimate(value, self._profile(candidate, parameter, value), parameter.unit)
        least = (NARROWEST * parameter.minimum_effect) ** 2
        variance = max(self._covariance[place, place], self._robust[place], self._jackknife(parameter))
        half = 1.96 * float(np.sqrt(variance + least))
        return Estimate(value, (max(parameter.low, value - half), min(parameter.high, value + half)), parameter.unit)

    @cached_property
    def _covariance(self) -> FloatArray:
        return self.fit.covariance

    @cached_property
    def _robust(self) -> FloatArray:
        return self.fit.robust_variance(self.data)

    def _jackknife(self, parameter: Parameter) -> float:
        """Return the variance of an estimate by how it moves when parts of the runs, or every second pose, are left out.

        Where a model is right the poses left out move an estimate less than chance does; where it is wrong, as one delay for all that
        is late, the answer depends on how often one looks.
        """
        models = {id(model): model for model in self.parts}
        moved = np.array([model.parameters[parameter.index] for model in models.values()])
        jackknife = float((len(moved) - 1) * np.var(moved)) if len(moved) >= 3 else 0.0
        shift = self.coarse.parameters[parameter.index] - self.fit.model.parameters[parameter.index]
        return max(jackknife, float(shift) ** 2)

    def _profile(self, candidate: Candidate, parameter: Parameter, value: float) -> tuple[float, float]:
        """Return the profile likelihood's bounds of a parameter, the rest as fitted."""

        def drop(trial: float) -> float:
            return self.fit.log_likelihood - self.fit.model.with_values([parameter], [trial]).filtered(self.data).total

        if candidate.name != "deadband":
            return profile_likelihood_bound(drop, value, parameter.low), profile_likelihood_bound(drop, value, parameter.high)
        # any threshold between two commanded speeds acts alike
        speeds, every = rim_speeds(self.fit.model.parameters, self.data), thresholds(self.fit.model.parameters, self.data)
        near = int(np.searchsorted(every, value))
        inside = [float(v) for v in every[max(0, near - NEIGHBOURS) : near + NEIGHBOURS] if drop(float(v)) < DROP] or [value]
        return float(speeds[speeds < min(inside)].max(initial=0.0)), float(speeds[speeds > max(inside)].min(initial=parameter.high))

"""Maximum likelihood of a drive's parameters and of the noise, by Fisher scoring."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.drive.candidates import Parameter
from swarm_envs.calibration.drive.filter import Filtered, filter_log
from swarm_envs.calibration.drive.information import information
from swarm_envs.calibration.drive.measured import Measured
from swarm_envs.calibration.drive.noise import NOISE
from swarm_envs.calibration.drive.parameters import PARAMETERS

NOISE_BOUNDS = (np.log(1e-6), np.log(10.0))
"""Of the logarithms of the noise's standard deviations."""
GOOD_ENOUGH = 0.02
"""Gain in log-likelihood under which a search ends."""
BLOCK = 5.0
"""Length in s of blocks whose scores count as independent when the model may be wrong."""


@dataclass(frozen=True)
class Model:
    """A drive with its noise."""

    parameters: FloatArray
    """(P,) in the order of :data:`swarm_envs.calibration.drive.parameters.PARAMETERS`."""
    noise: FloatArray
    """(5,) standard deviations, see :data:`swarm_envs.calibration.drive.noise.NOISE`."""
    gains: FloatArray
    """(R, 2) each robot's own factors on both gains."""

    @property
    def vector(self) -> FloatArray:
        """(P + 5 + 2R,) all that may be fitted: parameters, logarithms of the noise, factors."""
        return np.concatenate([self.parameters, np.log(self.noise), self.gains.ravel()])

    @classmethod
    def of(cls, vector: FloatArray) -> Model:
        """Return the model with this vector."""
        p, n = len(PARAMETERS), len(NOISE)
        return cls(vector[:p].copy(), np.exp(vector[p : p + n]), vector[p + n :].reshape(-1, 2).copy())

    def filtered(self, data: Measured) -> Filtered:
        """Run the filter over a log."""
        return filter_log(self.parameters, self.noise, self.gains, data)

    def with_values(self, parameters: Sequence[Parameter], values: Sequence[float]) -> Model:
        """Return a copy with some of the drive's parameters changed."""
        changed = self.parameters.copy()
        for parameter, value in zip(parameters, values, strict=True):
            changed[parameter.index] = value
        return dataclasses.replace(self, parameters=changed)


@dataclass(frozen=True)
class Free:
    """One entry of a model's vector that is fitted."""

    index: int
    low: float
    high: float
    step: float


NOISE_FREE = tuple(Free(len(PARAMETERS) + k, *NOISE_BOUNDS, 0.02) for k in range(len(NOISE)))
"""All of the noise."""


def free(parameters: Sequence[Parameter]) -> tuple[Free, ...]:
    """Return the entries of some of the drive's parameters."""
    return tuple(Free(p.index, p.low, p.high, p.step) for p in parameters)


def free_gains(robots: int) -> tuple[Free, ...]:
    """Return the entries of every robot's own factors."""
    begin = len(PARAMETERS) + len(NOISE)
    return tuple(Free(begin + k, 1e-3, 100.0, 1e-4) for k in range(2 * robots))


@dataclass(frozen=True)
class Fit:
    """A model at its likelihood's maximum."""

    model: Model
    log_likelihood: float
    fitted: tuple[Free, ...]
    """What was fitted, in the order of the matrices."""
    fisher: FloatArray
    """(Q, Q) expected information."""
    score: FloatArray
    """(N, Q) each pose's score."""

    @property
    def covariance(self) -> FloatArray:
        """(Q, Q) of the estimates, if the model is right."""
        return inverse(self.fisher)

    def robust_variance(self, data: Measured) -> FloatArray:
        """Return the variances (Q,) of the estimates when the model may be wrong.

        The larger of two sandwiches: over blocks of :data:`BLOCK` s, and over what is held out together, runs that may differ as a whole.
        """
        bread = self.covariance
        variances = []
        for scores in (block_sums(self.score, data), run_sums(self.score, data)):
            meat = scores.T @ scores * (len(scores) / max(1.0, len(scores) - 1.0))
            variances.append(np.diag(bread @ meat @ bread))
        return np.asarray(np.max(variances, axis=0))


def inverse(matrix: FloatArray) -> FloatArray:
    """Return a symmetric matrix's inverse; a direction without information gets a wide variance, not an error."""
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-8))
    scaled = matrix / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(scaled)
    result: FloatArray = (vectors / np.maximum(values, 1e-9)) @ vectors.T / np.outer(scale, scale)
    return result


def block_sums(values: FloatArray, data: Measured) -> FloatArray:
    """Return the sums (B, Q) of values (N, Q) over blocks of :data:`BLOCK` s within pieces."""
    labels = np.empty(len(data.times), np.int64)
    number = 0
    for piece in range(len(data.robot)):
        span = slice(data.first[piece], data.first[piece + 1])
        inside = np.floor((data.times[span] - data.times[span][0]) / BLOCK).astype(np.int64) if span.stop > span.start else np.empty(0, int)
        labels[span] = number + inside
        number += int(inside.max()) + 1 if len(inside) else 0
    sums = np.zeros((number, values.shape[1]))
    np.add.at(sums, labels, values)
    return sums


def run_sums(values: FloatArray, data: Measured) -> FloatArray:
    """Return the sums (G, Q) of values (N, Q) over the groups that are held out together."""
    sums = np.zeros((len(data.runs), values.shape[1]))
    np.add.at(sums, np.repeat(data.run, np.diff(data.first)), values)
    return sums


def maximise(model: Model, what: Sequence[Free], data: Measured, iterations: int = 15) -> Fit:
    """Fit a model by Fisher scoring: climb to the likelihood's maximum.

    Args:
        model: Where to start.
        what: What may change.
        data: The log.
        iterations: At most this many steps.
    """
    what = tuple(what)
    vector = model.vector
    index = np.array([entry.index for entry in what], np.int64)
    low, high = np.array([entry.low for entry in what]), np.array([entry.high for entry in what])
    # noise enters as a logarithm: a step of more than this leaves the region in which the slopes hold
    longest = np.where((index >= len(PARAMETERS)) & (index < len(PARAMETERS) + len(NOISE)), 1.5, np.inf)
    damping = 1e-3
    here = Model.of(vector).filtered(data)
    best = here.total
    score, fisher = _slopes(vector, what, here, data)
    for _ in range(iterations if what else 0):
        gradient = score.sum(axis=0)
        scale = np.maximum(np.diag(fisher), 1e-12)
        improved = 0.0
        while damping < 1e6:
            change = np.clip(np.linalg.solve(fisher + damping * np.diag(scale), gradient), -longest, longest)
            trial = vector.copy()
            trial[index] = np.clip(vector[index] + change, low, high)
            there = Model.of(trial).filtered(data)
            if there.total > best:
                begun, origin, factor = best, vector, 1.0
                while there.total > best:
                    best, vector, here = there.total, trial, there
                    # where the model is far off, the information expected is more than there is, and steps are too short
                    factor *= 2.0
                    trial = origin.copy()
                    trial[index] = np.clip(origin[index] + np.clip(factor * change, -longest, longest), low, high)
                    there = Model.of(trial).filtered(data)
                improved = best - begun
                damping = max(damping * 0.1, 1e-9)
                break
            if damping > 1.0 and abs(float(gradient @ change)) < GOOD_ENOUGH:
                break
            damping *= 10.0 if damping > 1e-6 else 1e4
        if improved < GOOD_ENOUGH:
            break
        score, fisher = _slopes(vector, what, here, data)
    return Fit(Model.of(vector), best, what, fisher, score)


def _slopes(vector: FloatArray, what: tuple[Free, ...], here: Filtered, data: Measured) -> tuple[FloatArray, FloatArray]:
    """Return each pose's score (N, Q) and the expected information (Q, Q)."""
    innovation, covariance, steps = [here.innovation], [here.covariance], []
    for entry in what:
        step = entry.step if vector[entry.index] + entry.step <= entry.high else -entry.step
        trial = vector.copy()
        trial[entry.index] += step
        there = Model.of(trial).filtered(data)
        innovation.append(there.innovation)
        covariance.append(there.covariance)
        steps.append(step)
    score, fisher = np.zeros((len(data.times), len(what))), np.zeros((len(what), len(what)))
    information(np.array(innovation), np.array(covariance), np.array(steps), score, fisher)
    return score, fisher

"""Effect ``robot_spread``: robots whose gains differ, and the gains that all have in common beside that."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2
from scipy.stats import f as f_distribution

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.drive.candidates import BY_NAME, SPREAD
from swarm_envs.calibration.drive.fitting import Fit, free_gains, inverse
from swarm_envs.calibration.selection.causes import Estimate
from swarm_envs.calibration.selection.forward import SIGNIFICANT, Evidence
from swarm_envs.calibration.selection.profile import DROP

ROBOT_SPREAD = SPREAD.name
GAINS = ("linear_gain", "angular_gain")
"""Effects that each robot may have a factor of its own on, in the order of the factors."""


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
    inside = grid[losses < losses[best] + DROP]
    # the normalising constant of the estimates' own density
    evidence = -float(losses[best]) + 0.5 * float(np.sum(np.log(values)))
    return Spread(float(np.exp(grid[best])), (float(np.exp(inside[0])), float(np.exp(inside[-1]))), evidence)


def spread_of(fit: Fit, robots: int) -> Spread:
    """Return how the factors of so many robots scatter in a fit."""
    return factors_spread(fit.model.gains.ravel(), factors_covariance(fit, robots))


def factors_covariance(fit: Fit, robots: int) -> FloatArray:
    """Return the covariance (2R, 2R) of the robots' factors in a fit."""
    entries = [k for k, entry in enumerate(fit.fitted) if entry in free_gains(robots)]
    return np.asarray(inverse(fit.fisher)[np.ix_(entries, entries)])


def spread_estimates(fit: Fit, robots: tuple[str, ...], levels: int) -> dict[str, Estimate]:
    """Return how much robots differ, and each one's factors.

    Args:
        fit: With the robots' factors.
        robots: Their names.
        levels: Number of gains that all robots have in common, which were taken out of the factors.
    """
    count = len(robots)
    covariance = factors_covariance(fit, count)
    spread = factors_spread(fit.model.gains.ravel(), covariance)
    freedom = 2 * count - levels
    exact = spread.sd * np.sqrt(2 * count / chi2.ppf((0.975, 0.025), freedom))
    interval = (min(spread.ci95[0], float(exact[0])), max(spread.ci95[1], float(exact[1])))
    found = {"sd": Estimate(spread.sd * float(np.sqrt(2 * count / freedom)), interval, "1")}
    for k, robot in enumerate(robots):
        for j, name in enumerate(("linear", "angular")):
            value, half = float(fit.model.gains[k, j]), 1.96 * float(np.sqrt(covariance[2 * k + j, 2 * k + j]))
            found[f"{robot}.{name}_gain"] = Estimate(value, (value - half, value + half), "1")
    return found


@dataclass(frozen=True)
class Levelled:
    """A fit whose robots' factors have a mean of one where the gains that they have in common are named."""

    fit: Fit
    evidence: dict[str, Evidence]
    """Of all named effects, those gains among them."""
    levels: dict[str, float]
    """By gain that all robots have in common, half its 95 % interval as a share of it."""


def level_gains(fit: Fit, evidence: dict[str, Evidence]) -> Levelled:
    """Take out of the robots' own factors what all have in common, and name it where chance would not give robots such a mean."""
    factors = fit.model.gains - 1.0
    count = len(factors)
    evidence, levels = dict(evidence), dict[str, float]()
    about_mean = [float(np.sum((factors[:, k] - factors[:, k].mean()) ** 2)) for k in range(2)]
    about_one = [float(np.sum(factors[:, k] ** 2)) for k in range(2)]
    for column, name in enumerate(GAINS):
        left = about_mean[column] + (about_mean if GAINS[1 - column] in evidence else about_one)[1 - column]
        mean = float(factors[:, column].mean())
        ratio = count * mean**2 / max(left / (2 * count - 1), 1e-12)
        p = min(1.0, 2.0 * float(f_distribution.sf(ratio, 1, 2 * count - 1)))
        if name not in evidence:
            if p >= SIGNIFICANT or abs(mean) <= BY_NAME[name].parameters[0].minimum_effect:
                continue
            evidence[name] = Evidence(0.5 * (2 * count) * float(np.log1p(ratio / (2 * count - 1))), p)
        level = float(fit.model.gains[:, column].mean())
        parameters, gains = fit.model.parameters.copy(), fit.model.gains.copy()
        parameters[BY_NAME[name].parameters[0].index] *= level
        gains[:, column] /= level
        fit = dataclasses.replace(fit, model=dataclasses.replace(fit.model, parameters=parameters, gains=gains))
        levels[name] = 1.96 * float(np.sqrt(left / (2 * count - 1) / count)) / level
    return Levelled(fit, evidence, levels)

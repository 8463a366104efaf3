"""A correction over the arena with edges: a floor of two kinds, divided by a line that the data draw.

A smooth function of place blurs an edge and needs robots everywhere; a floor of two kinds needs them on either side of the line. Both
levels and the smooth function whose sign tells the kinds apart are fitted together, by the motion over each window as the robot
passes from place to place in it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from swarm_envs.calibration.corrections import SHARPNESS, Patches, Term, carrier, second_kind
from swarm_envs.calibration.criticism import Residuals, tamed
from swarm_envs.calibration.log import BoolArray, FloatArray
from swarm_envs.calibration.smoothing import Smooth, by_group, cells, folds_of

WIDTHS = (0.2, 0.3, 0.45)
"""Lengths in m over which the line between the kinds may bend."""
NOISE = (0.03, 0.1, 0.3)
"""Errors that are left, as shares of those without the correction."""
STEPS = 150
"""Steps of a fit at most."""
BEYOND = 1.0
"""How far levels may be beyond those that a smooth correction reaches, as a share of their difference."""


@dataclass(frozen=True)
class Floor:
    """A correction of two levels that was tried."""

    term: Term
    gain: float
    """In log-likelihood of held-out windows, in nats."""


def two_kinds(smooth: Smooth, found: Residuals) -> Floor:
    """Divide the arena by kinds of floor, from where a smooth correction over it is large or small.

    The length over which the line bends and the noise are what predicts held-out windows best.
    """
    errors = tamed(found.errors[:, smooth.channel])
    fold_of, folds = folds_of(found.group)
    first = smooth.term(found)
    places, carried = found.along[..., :2], carrier(smooth.carrier, found.along[..., 2:])
    centres = cells(places.reshape(-1, 2))
    starts = [first.basis.weighed(places.reshape(-1, 2), weights) for weights in (*first.without[:folds], first.weights)]
    total, best = float(errors @ errors), None
    for width in WIDTHS:
        basis = Patches.over(centres, width)
        parts = basis(places.reshape(-1, 2)).reshape(*carried.shape, -1)
        for share in NOISE:
            noise = share * float(np.sqrt(total / len(errors)))
            without, left = [], 0.0
            for fold in range(folds):
                kept = fold_of != fold
                weights = _fitted(parts, carried, errors, starts[fold].reshape(carried.shape), kept, noise)
                missed = errors - _mean_correction(parts, carried, weights)
                left += float(np.sum(missed[~kept] ** 2))
                without.append(weights)
            if best is None or left < best[0]:
                best = (left, basis, parts, noise, without)
    assert best is not None
    left, basis, parts, noise, without = best
    weights = _fitted(parts, carried, errors, starts[-1].reshape(carried.shape), np.ones(len(errors), bool), noise)
    term = Term(smooth.channel, smooth.carrier, basis, weights, by_group(without, found.group))
    return Floor(term, 0.5 * len(errors) * float(np.log(total / max(left, 1e-300))))


def _mean_correction(parts: FloatArray, carried: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the correction (W,) of windows, the mean over the moments of each."""
    share = second_kind(parts @ weights[2:])
    return np.asarray((carried * (weights[0] + (weights[1] - weights[0]) * share)).mean(axis=1))


def _fitted(parts: FloatArray, carried: FloatArray, errors: FloatArray, start: FloatArray, kept: BoolArray, noise: float) -> FloatArray:
    """Return the likeliest weights (K + 3,) of windows that are kept.

    Args:
        parts: (W, T, K + 1) of the dividing function at T moments of each window.
        carried: (W, T) what the correction is proportional to.
        errors: (W,) measured less predicted.
        start: (W, T) a smooth correction for each unit of the carrier.
        kept: (W,) windows that are fitted.
        noise: Standard deviation of what will be left.
    """
    values, size, error = parts[kept].reshape(-1, parts.shape[2]), carried[kept], errors[kept]
    low, high = np.quantile(start[kept][np.abs(size) > 0], (0.02, 0.98)) if np.any(size) else (0.0, 0.0)
    reach = max(float(high - low), 1e-9)
    wanted = np.clip((start[kept].ravel() - 0.5 * (low + high)) / reach * 3.0, -1.0, 1.0)
    dividing = np.linalg.solve(values.T @ values + 0.1 * np.eye(values.shape[1]), values.T @ wanted)
    loss = _loss(values, size, error, noise)
    bounds = [(low - BEYOND * reach, high + BEYOND * reach)] * 2 + [(None, None)] * len(dividing)
    begin = np.concatenate([[low, high], dividing])
    return np.asarray(minimize(loss, begin, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": STEPS}).x)


def _loss(values: FloatArray, size: FloatArray, error: FloatArray, noise: float) -> Callable[[FloatArray], tuple[float, FloatArray]]:
    """Return the negative logarithm of the posterior density of weights, with its slope."""

    def loss(weights: FloatArray) -> tuple[float, FloatArray]:
        share = second_kind(values @ weights[2:])
        second = share.reshape(size.shape)
        step = weights[1] - weights[0]
        missed = error - (size * (weights[0] + step * second)).mean(axis=1)
        slope = -missed[:, None] / noise**2 * size / size.shape[1]
        dividing = values.T @ (slope.ravel() * step * SHARPNESS * share * (1.0 - share)) + weights[2:]
        levels = [float(np.sum(slope * (1.0 - second))), float(np.sum(slope * second))]
        return 0.5 * float(missed @ missed) / noise**2 + 0.5 * float(weights[2:] @ weights[2:]), np.concatenate([levels, dividing])

    return loss

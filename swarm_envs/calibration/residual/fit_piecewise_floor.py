"""A correction over the arena with edges: a floor of two kinds, divided by a line that the data draw.

A smooth function of place blurs an edge and needs robots everywhere; a floor of two kinds needs them on either side of the line. Both
levels and the function whose sign tells the kinds apart are fitted together, by the motion over each window as the robot
passes from place to place in it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.residual.corrections import Term, regressor
from swarm_envs.calibration.residual.piecewise_floor import SHARPNESS, PiecewiseFloor, Shape, share_of_second
from swarm_envs.calibration.residual.residuals import Residuals, winsorised
from swarm_envs.calibration.residual.smoothing import FOLDS, PARTS, Smooth, by_group, cells, folds_of

SHAPES = (Shape(0.2, 1.0), Shape(0.4, 1.0), Shape(0.25, 0.3, 5.0, 5.0), Shape(0.3, 0.3, 5.0, 0.5))
"""Shapes that are tried: of any line, of a line with few bends, of stripes and ellipses, of round patches."""
NOISE = (0.1, 0.03, 0.3)
"""Errors that are left, as shares of those without the correction; the first is that by which the shape is chosen."""
MOST = 500
"""Windows that are looked at, about; of more, each second or third and so on."""
STEPS, STEPS_ON = 80, 40
"""Steps of a fit at most, from a smooth correction and from a fit to fewer runs."""
BEYOND = 1.0
"""How far levels may be beyond those that a smooth correction reaches, as a share of their difference."""


@dataclass(frozen=True)
class Floor:
    """A correction of two levels that was tried."""

    term: Term
    gain: float
    """In log-likelihood of held-out windows, in nats."""


def fit_piecewise_floor(smooth: Smooth, found: Residuals) -> Floor:
    """Divide the arena by kinds of floor, from where a smooth correction over it is large or small.

    The shape of the line and the noise are what predicts held-out windows best.
    """
    drives = _Drives(smooth, found, max(1, round(len(found.errors) / MOST)))
    places, total = drives.places, float(drives.errors @ drives.errors)
    centres, scale = cells(places), float(np.sqrt(total / len(drives.errors)))
    shapes = [PiecewiseFloor.over(places, centres, shape) for shape in SHAPES]
    best = min((drives.without(basis, NOISE[0] * scale, FOLDS) for basis in shapes), key=lambda trial: trial.left)
    others = [drives.without(best.basis, share * scale, FOLDS, best) for share in NOISE[1:]]
    best = min([best, *others], key=lambda trial: trial.left)
    judged = by_group(drives.without(best.basis, best.noise, PARTS, best).weights, found.group)
    weights = drives.without(best.basis, best.noise, 0).weights[0]
    gain = 0.5 * len(found.errors) * float(np.log(total / max(best.left, 1e-300)))
    return Floor(Term(smooth.channel, smooth.regressor, best.basis, weights, judged), gain)


@dataclass(frozen=True)
class _Trial:
    """A floor of two kinds, fitted without each fold."""

    basis: PiecewiseFloor
    noise: float
    weights: list[FloatArray]
    left: float
    """Squares of the errors that are left in the folds that weights were not fitted to."""


class _Drives:
    """What robots did over the arena, and fits to it."""

    def __init__(self, smooth: Smooth, found: Residuals, stride: int) -> None:
        self.smooth, self.found = smooth, found
        self.group = found.group[::stride]
        self.errors = winsorised(found.errors[::stride, smooth.channel])
        self.regressor = regressor(smooth.regressor, found.along[::stride, :, 2:])
        self.places = found.along[::stride, :, :2].reshape(-1, 2)
        self.by_place = smooth.basis(self.places)
        self.parts: tuple[PiecewiseFloor, FloatArray] | None = None

    def without(self, basis: PiecewiseFloor, noise: float, most: int, near: _Trial | None = None) -> _Trial:
        """Fit a floor without each of so many folds, or once to all when there are none.

        Args:
            basis: What divides it.
            noise: Standard deviation of what will be left.
            most: Number of folds at most.
            near: A trial with fewer folds, each of which holds out what these do and more: where to start.
        """
        if self.parts is None or self.parts[0] is not basis:
            self.parts = basis, basis(self.places).reshape(*self.regressor.shape, -1)
        parts = self.parts[1]
        every, folds = self.smooth.fitted(self.found, max(1, most))
        number = folds_of(self.found.group, max(1, most))[1]
        fold_of = self.group % number if most else np.full(len(self.errors), -1)
        weights, left = [], 0.0
        for fold, flat in enumerate(folds if most else [every]):
            kept = fold_of != fold
            start = (self.by_place @ flat).reshape(self.regressor.shape)[kept]
            begin = None if near is None else near.weights[fold % len(near.weights)]
            weights.append(_fitted(parts[kept], self.regressor[kept], self.errors[kept], start, noise, begin))
            missed = self.errors - _mean_correction(parts, self.regressor, weights[-1])
            left += float(np.sum(missed[~kept] ** 2))
        return _Trial(basis, noise, weights, left)


def _mean_correction(parts: FloatArray, regressor: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the correction (W,) of windows, the mean over the moments of each."""
    share = share_of_second(parts @ weights[2:])
    return np.asarray((regressor * (weights[0] + (weights[1] - weights[0]) * share)).mean(axis=1))


def _fitted(
    parts: FloatArray, size: FloatArray, errors: FloatArray, smooth: FloatArray, noise: float, begin: FloatArray | None
) -> FloatArray:
    """Return the likeliest weights (K + 3,).

    Args:
        parts: (W, T, K + 1) of the dividing function at T moments of each window.
        size: (W, T) what the correction is proportional to.
        errors: (W,) measured less predicted.
        smooth: (W, T) a smooth correction for each unit of that.
        noise: Standard deviation of what will be left.
        begin: (K + 3,) weights to start from; those nearest to the smooth correction by default.
    """
    values = parts.reshape(-1, parts.shape[2])
    low, high = np.quantile(smooth[np.abs(size) > 0], (0.02, 0.98)) if np.any(size) else (0.0, 0.0)
    reach = max(float(high - low), 1e-9)
    steps = STEPS_ON
    if begin is None:
        wanted = np.clip((smooth.ravel() - 0.5 * (low + high)) / reach * 3.0, -1.0, 1.0)
        dividing = np.linalg.solve(values.T @ values + 0.1 * np.eye(values.shape[1]), values.T @ wanted)
        begin, steps = np.concatenate([[low, high], dividing]), STEPS
    bounds = [(low - BEYOND * reach, high + BEYOND * reach)] * 2 + [(None, None)] * (len(begin) - 2)
    loss = _loss(values, size, errors, noise)
    return np.asarray(minimize(loss, begin, jac=True, method="L-BFGS-B", bounds=bounds, options={"maxiter": steps}).x)


def _loss(values: FloatArray, size: FloatArray, error: FloatArray, noise: float) -> Callable[[FloatArray], tuple[float, FloatArray]]:
    """Return the negative logarithm of the posterior density of weights, with its slope."""

    def loss(weights: FloatArray) -> tuple[float, FloatArray]:
        share = share_of_second(values @ weights[2:])
        second = share.reshape(size.shape)
        step = weights[1] - weights[0]
        missed = error - (size * (weights[0] + step * second)).mean(axis=1)
        slope = -missed[:, None] / noise**2 * size / size.shape[1]
        dividing = values.T @ (slope.ravel() * step * SHARPNESS * share * (1.0 - share)) + weights[2:]
        levels = [float(np.sum(slope * (1.0 - second))), float(np.sum(slope * second))]
        return 0.5 * float(missed @ missed) / noise**2 + 0.5 * float(weights[2:] @ weights[2:]), np.concatenate([levels, dividing])

    return loss

"""Corrections as smooth functions: ridge regressions on radial basis functions of a covariate, held against held-out windows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.arrays import FloatArray, IntArray
from swarm_envs.calibration.residual.corrections import (
    COVARIATES,
    ONE_BY_ONE,
    PERIODIC,
    PLANE,
    REGRESSORS,
    Basis,
    Covariates,
    Term,
    covariates_of,
)
from swarm_envs.calibration.residual.residuals import Residuals, winsorised

SPACING = 0.08
"""Least distance in m of the basis functions over the arena."""
MOST = 200
"""Basis functions over the arena at most."""
WIDTHS = (0.2, 0.6)
"""Lengths in m over which a correction may change over the arena."""
ALONG = 9
"""Basis functions along a number."""
PENALTIES = np.geomspace(1e-3, 1e3, 13)
"""Ridge penalties tried."""
FOLDS = 6
"""Parts of the runs, each held out once, by which corrections are compared."""
PARTS = 18
"""Parts of the runs, each held out once, on which the chosen correction is judged: mostly a run each. A multiple of FOLDS."""
RESAMPLES = 499
"""Random signs given to the blocks of windows."""


@dataclass(frozen=True)
class Smooth:
    """A correction that was tried on a channel."""

    channel: int
    regressor: str
    basis: Basis
    values: FloatArray
    """(W, M + 1) of its functions, times the regressor."""
    gain: float
    """In log-likelihood of held-out windows, in nats."""
    penalty: float

    def fitted(self, found: Residuals, parts: int) -> tuple[FloatArray, list[FloatArray]]:
        """Return the weights (M + 1,) fitted to all windows, and those without each of so many parts of the runs."""
        errors = winsorised(found.errors[:, self.channel])
        squares, products, _, folds = _sums(self.values, errors, found.group, parts)
        ridge = self.penalty * np.eye(self.values.shape[1])
        every = np.linalg.solve(squares.sum(axis=0) + ridge, products.sum(axis=0))
        return every, [np.linalg.solve(squares.sum(axis=0) - squares[f] + ridge, products.sum(axis=0) - products[f]) for f in range(folds)]

    def term(self, found: Residuals) -> Term:
        """Return the correction, fitted to all windows and without each part of the runs."""
        every, without = self.fitted(found, PARTS)
        return Term(self.channel, self.regressor, self.basis, every, by_group(without, found.group))


def folds_of(group: IntArray, most: int) -> tuple[IntArray, int]:
    """Return the fold (W,) of each window by its group, and the number of folds, at most so many."""
    folds = min(most, int(group.max()) + 1)
    return group % folds, folds


def by_group(without: Sequence[FloatArray], group: IntArray) -> FloatArray:
    """Return for each group (G, Q) the weights fitted without its fold."""
    return np.array([without[g % len(without)] for g in range(int(group.max()) + 1)])


def smooth_corrections(found: Residuals) -> list[Smooth]:
    """Try every correction, the simplest covariates first; the penalty of each is what predicts held-out windows best."""
    at = covariates_of(found)
    trials = []
    for name in COVARIATES:
        for basis in _bases(name, at):
            functions = basis(at.coordinates(name))
            for channel, regressors in REGRESSORS.items():
                errors = winsorised(found.errors[:, channel])
                for regressor in regressors:
                    values = functions * at.regressor(regressor)[:, None]
                    trials.append(Smooth(channel, regressor, basis, values, *_heldout_gain(values, errors, found.group)))
    return trials


def cells(places: FloatArray) -> FloatArray:
    """Return centres (M, 2) of the cells of a grid in which there are places (W, 2); at most :data:`MOST`."""
    spacing = SPACING
    while len(inside := np.unique(np.floor(places / spacing), axis=0)) > MOST:
        spacing *= 1.2
    return np.asarray((inside + 0.5) * spacing)


def _bases(name: str, at: Covariates) -> list[Basis]:
    """Return bases where the data are; none where a covariate does not vary."""
    coordinates = at.coordinates(name)
    if name == ONE_BY_ONE:
        kinds = np.unique(coordinates)
        return [Basis.at(name, kinds[:, None], 0.1)] if len(kinds) > 1 else []
    if name == PERIODIC:
        angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
        return [Basis.at(name, np.column_stack([np.cos(angles), np.sin(angles)]), 0.7)]
    if name == PLANE:
        return [Basis.at(name, cells(coordinates), width) for width in WIDTHS]
    low, high = np.quantile(coordinates, (0.01, 0.99))
    if high - low < 1e-6:
        return []
    return [Basis.at(name, np.linspace(low, high, ALONG)[:, None], 1.5 * (high - low) / (ALONG - 1))]


def _sums(values: FloatArray, errors: FloatArray, group: IntArray, most: int = FOLDS) -> tuple[FloatArray, FloatArray, FloatArray, int]:
    """Return normal equations of each fold: (F, M, M), (F, M), and sums of squares (F,); and the number of folds."""
    fold_of, folds = folds_of(group, most)
    squares = np.empty((folds, values.shape[1], values.shape[1]))
    products, totals = np.empty((folds, values.shape[1])), np.empty(folds)
    for fold in range(folds):
        inside = fold_of == fold
        squares[fold], products[fold] = values[inside].T @ values[inside], values[inside].T @ errors[inside]
        totals[fold] = float(errors[inside] @ errors[inside])
    return squares, products, totals, folds


def _heldout_gain(values: FloatArray, errors: FloatArray, group: IntArray) -> tuple[float, float]:
    """Return the gain in log-likelihood of held-out windows over no correction, and the penalty with the most."""
    squares, products, totals, folds = _sums(values, errors, group)
    scale = max(float(np.trace(squares.sum(axis=0))) / values.shape[1], 1e-12)
    left = np.zeros(len(PENALTIES))
    for fold in range(folds):
        eigen, vectors = np.linalg.eigh(squares.sum(axis=0) - squares[fold])
        turned = vectors.T @ (products.sum(axis=0) - products[fold])
        for k, penalty in enumerate(PENALTIES):
            weights = vectors @ (turned / (np.maximum(eigen, 0.0) + penalty * scale))
            left[k] += totals[fold] - 2.0 * weights @ products[fold] + weights @ squares[fold] @ weights
    best = int(np.argmin(left))
    return 0.5 * len(errors) * float(np.log(totals.sum() / max(left[best], 1e-300))), float(PENALTIES[best]) * scale


def sign_flip_p_value(trials: Sequence[Smooth], found: Residuals) -> float:
    """Return the p-value of there being nothing: how often chance yields a gain as large as the largest.

    Errors get a random sign, one for each block of windows, which leaves alike what errs alike; the corrections of each draw are
    fitted and held against held-out windows as the real ones were.
    """
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (int(found.block.max()) + 1, RESAMPLES))
    chance = np.zeros(RESAMPLES)
    for trial in trials:
        errors = winsorised(found.errors[:, trial.channel])
        squares, _, totals, folds = _sums(trial.values, errors, found.group)
        signed = np.empty((folds, trial.values.shape[1], RESAMPLES))
        for fold in range(folds):
            inside = found.group % folds == fold
            sums = np.zeros((len(signs), trial.values.shape[1]))
            np.add.at(sums, found.block[inside], trial.values[inside] * errors[inside, None])
            signed[fold] = sums.T @ signs
        for stiffer in (1.0, 30.0):
            left = np.full(RESAMPLES, totals.sum())
            for fold in range(folds):
                ridge = squares.sum(axis=0) - squares[fold] + stiffer * trial.penalty * np.eye(len(signed[fold]))
                weights = np.linalg.solve(ridge, signed.sum(axis=0) - signed[fold])
                left += np.einsum("ms,ms->s", weights, squares[fold] @ weights - 2.0 * signed[fold])
            chance = np.maximum(chance, 0.5 * len(errors) * np.log(totals.sum() / np.maximum(left, 1e-300)))
    largest = max(trial.gain for trial in trials)
    return float((1 + np.sum(chance >= largest)) / (1 + RESAMPLES))

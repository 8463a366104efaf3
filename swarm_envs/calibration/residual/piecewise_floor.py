"""A correction over the arena with edges: two levels, divided where a function of place changes its sign."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.residual.corrections import PLANE, Basis, kernel, weighted_sum


@dataclass(frozen=True)
class Shape:
    """What lines between two kinds of floor are likely to look like: standard deviations of the parts of what divides them."""

    width: float
    """Length in m over which the line bends."""
    bent: float
    """Of the smooth function that bends it."""
    round: float = 0.0
    """Of the slopes and the roundness of the conic section beside that; 0 without one."""
    oblong: float = 0.0
    """Of what makes the conic longer than wide; as large as ``round`` for a stripe, smaller for a patch."""


@dataclass(frozen=True)
class PiecewiseFloor(Basis):
    """Two levels over the arena, divided where a function changes its sign: a floor of two kinds.

    The dividing function is smooth; it may have a conic section for a trend, whose line closes or goes on where no robot has been.
    Weights are the two levels, then those of the dividing function.
    """

    round: float
    """Standard deviation of the slopes and the roundness of the conic; 0 without one."""
    oblong: float
    """That of what makes the conic longer than wide."""
    middle: FloatArray
    """(2,) of the places, in m."""
    reach: float
    """rms distance of the places from there in m."""

    def __call__(self, coordinates: FloatArray) -> FloatArray:
        """Return the values (W, K + 1) of the dividing function's parts at coordinates (W, 2)."""
        parts = [kernel(coordinates, self.centres, self.width) @ self.mixed]
        if self.round > 0.0:
            x, y = ((coordinates - self.middle) / self.reach).T
            parts += [self.round * np.column_stack([x, y, x * x + y * y]), self.oblong * np.column_stack([x * x - y * y, 2.0 * x * y])]
        return np.column_stack([*parts, np.full(len(coordinates), max(1.0, self.round))])

    def weighed(self, coordinates: FloatArray, weights: FloatArray) -> FloatArray:
        """Return the correction (W,) at coordinates (W, 2) for weights (K + 3,), or (W, K + 3) if each has its own."""
        share = share_of_second(weighted_sum(self(coordinates), weights[..., 2:]))
        return np.asarray(weights[..., 0] + (weights[..., 1] - weights[..., 0]) * share)

    @classmethod
    def over(cls, places: FloatArray, centres: FloatArray, shape: Shape) -> PiecewiseFloor:
        """Return the basis with these centres (M, 2) for places (N, 2)."""
        values, vectors = np.linalg.eigh(kernel(centres, centres, shape.width))
        kept = values > 1e-5 * values.max()
        middle = places.mean(axis=0)
        reach = float(np.sqrt(np.mean(np.sum((places - middle) ** 2, axis=1)))) + 1e-9
        mixed = shape.bent * vectors[:, kept] / np.sqrt(values[kept])
        return cls(PLANE, centres, shape.width, mixed, shape.round, shape.oblong, middle, reach)


SHARPNESS = 8.0
"""Slope of the change from one kind to the other; the smooth function that divides them is of the order of one."""


def share_of_second(dividing: FloatArray) -> FloatArray:
    """Return how much places are of the second kind, 0 to 1, by the function that divides the kinds."""
    return np.asarray(1.0 / (1.0 + np.exp(-np.clip(SHARPNESS * dividing, -40.0, 40.0))))

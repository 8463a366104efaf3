"""Each pose's score and the information that a log holds, from finite differences of what the filter makes of it."""

from __future__ import annotations

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.compiled import compiled


def information(innovation: FloatArray, covariance: FloatArray, steps: FloatArray, score: FloatArray, fisher: FloatArray) -> None:
    """Write each pose's score (N, Q) and the expected information (Q, Q) of a Gaussian model from finite differences.

    Args:
        innovation: (Q + 1, N, 3) at the parameters, then at each parameter's step.
        covariance: (Q + 1, N, 3, 3) likewise.
        steps: (Q,) the steps.
        score: (N, Q) written.
        fisher: (Q, Q) written.
    """
    q = steps.shape[0]
    _information(
        innovation, covariance, steps, np.empty((3, 3)), np.empty(3), np.empty((q, 3)), np.empty((q, 3)), np.empty((q, 3, 3)), score, fisher
    )


@compiled(_nrt=False)
def _information(
    innovation: FloatArray, covariance: FloatArray, steps: FloatArray, inverse: FloatArray, nu: FloatArray, slope: FloatArray,
    weighted: FloatArray, product: FloatArray, score: FloatArray, fisher: FloatArray,
) -> None:  # fmt: skip
    """Do the work of :func:`information`; the arrays between ``steps`` and ``score`` are working space."""
    fisher[:] = 0.0
    for n in range(innovation.shape[1]):
        _invert(covariance[0, n], inverse)
        for a in range(3):
            nu[a] = 0.0
            for b in range(3):
                nu[a] += inverse[a, b] * innovation[0, n, b]
        for i in range(steps.shape[0]):
            value = 0.0
            for a in range(3):
                slope[i, a] = (innovation[i + 1, n, a] - innovation[0, n, a]) / steps[i]
                for c in range(3):
                    change = (covariance[i + 1, n, a, c] - covariance[0, n, a, c]) / steps[i]
                    value += 0.5 * nu[a] * change * nu[c]
                    for b in range(3):
                        product[i, b, c] = inverse[b, a] * change + (product[i, b, c] if a > 0 else 0.0)
            for a in range(3):
                weighted[i, a] = inverse[a, 0] * slope[i, 0] + inverse[a, 1] * slope[i, 1] + inverse[a, 2] * slope[i, 2]
                value -= slope[i, a] * nu[a] + 0.5 * product[i, a, a]
            score[n, i] = value
            for j in range(i + 1):
                value = 0.0
                for a in range(3):
                    value += slope[i, a] * weighted[j, a]
                    for b in range(3):
                        value += 0.5 * product[i, a, b] * product[j, b, a]
                fisher[i, j] += value
    for i in range(steps.shape[0]):
        for j in range(i):
            fisher[j, i] = fisher[i, j]


@compiled(_nrt=False)
def _invert(m: FloatArray, inverse: FloatArray) -> float:
    """Write the inverse of a symmetric 3 x 3 matrix; returns the determinant."""
    a, b, c, d, e, f = m[0, 0], m[0, 1], m[0, 2], m[1, 1], m[1, 2], m[2, 2]
    i00, i01, i02 = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * i00 + b * i01 + c * i02
    inverse[0, 0] = i00 / determinant
    inverse[0, 1] = inverse[1, 0] = i01 / determinant
    inverse[0, 2] = inverse[2, 0] = i02 / determinant
    inverse[1, 1] = (a * f - c * c) / determinant
    inverse[1, 2] = inverse[2, 1] = (b * c - a * e) / determinant
    inverse[2, 2] = (a * d - b * b) / determinant
    return float(max(determinant, 1e-300))

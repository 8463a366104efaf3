"""How much less a metric errs on held-out runs, and the interval of that."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.arrays import BoolArray, FloatArray

RESAMPLES = 1000
"""Bootstrap resamples of the held-out groups."""


@dataclass(frozen=True)
class Gain:
    """One metric on held-out runs; less is better in all of them."""

    metric: str
    """``position`` or ``heading``: rms of the error at the ends of the windows; else one of
    :mod:`swarm_envs.calibration.validation.swarm`."""
    horizon_s: float | None
    """Length of the windows; None where whole runs are compared."""
    unit: str
    before: float
    """With the world as it was."""
    after: float
    """With the effects, fitted to the other runs."""
    ci95: tuple[float, float]
    """Of ``before - after``, by resampling runs; those with turns among themselves, and those without."""
    noise_floor: float | None
    """What the tracker's noise, or chance, alone would give; None where that is not known."""
    reference: float | None = None
    """What a flexible regression gives that knows no mechanics (:mod:`swarm_envs.calibration.prediction.reference`), on the same
    held-out runs."""


def bootstrap(sums: FloatArray, strata: BoolArray | None = None, *, root: bool = True) -> tuple[float, float]:
    """Return the 95 % interval of the fall from before to after, by resampling groups.

    Args:
        sums: (G, 3) each group's sums of errors before and after, and their number.
        strata: (G,) two kinds of groups, resampled among themselves; one kind by default.
        root: Whether the sums are of squares, and the fall is that of their root mean.
    """
    generator = np.random.default_rng(0)
    drawn = np.zeros((RESAMPLES, 3))
    for kind in (False, True):
        part = sums if strata is None else sums[strata == kind]
        if len(part) and not (strata is None and kind):
            drawn += part[generator.integers(len(part), size=(RESAMPLES, len(part)))].sum(axis=1)
    means = drawn[:, :2] / drawn[:, 2:]
    means = np.sqrt(means) if root else means
    low, high = np.quantile(means[:, 0] - means[:, 1], (0.025, 0.975))
    return float(low), float(high)

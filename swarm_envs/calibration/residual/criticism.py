"""Which channels of a model depart from what was measured, and on what that depends."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.arrays import FloatArray, IntArray
from swarm_envs.calibration.residual.residuals import CHANNELS, LABELS, Residuals, quantile_bins, winsorised

BINS = 8
"""Groups of equally many windows along a variable."""
CERTAIN = 1e-3
"""Greatest p-value, corrected for the number of tests, at which a dependence is reported."""
RESAMPLES = 2999
"""Random signs given to the blocks: the smallest p-value is one in so many and one."""


@dataclass(frozen=True)
class Discrepancy:
    """A channel that departs from zero."""

    channel: str
    depends_on: str
    """A covariate, or ``nothing``: the departure is the same everywhere."""
    size: float
    """Root mean square of the departures explained by the covariate, or the mean."""
    unit: str
    p_value: float
    """Corrected for the number of tests, and for windows that err alike."""


def criticise(found: Residuals) -> list[Discrepancy]:
    """Return the departures from zero that are certain, the largest share of the variance first.

    Each channel is grouped by each covariate, as it is and in the direction of travel. Blocks of windows are given random signs:
    the largest statistic of all that this yields is what chance would yield, however windows of a block err alike.
    """
    if len(found.errors) < 20:
        return []
    blocks = int(found.block.max()) + 1
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (RESAMPLES, blocks))
    entries: list[tuple[float, Discrepancy]] = []
    scores: list[FloatArray] = []
    travel = np.sign(np.where(np.abs(found.motion[:, 0]) > 1e-3, found.motion[:, 0], 0.0))
    for k, (channel, unit) in enumerate(CHANNELS.items()):
        errors = winsorised(found.errors[:, k])
        if np.ptp(errors) == 0.0:
            continue
        variance = float(np.mean(errors**2))
        for direction in (np.ones(len(errors)), travel):
            signed = errors * direction
            entries.append((float(signed.mean()) ** 2 / variance, Discrepancy(channel, "nothing", abs(float(signed.mean())), unit, 1.0)))
            scores.append(_scores(signed, np.zeros(len(errors)), found.block, signs))
            signed = signed - signed.mean()
            for name, values in found.covariates.items():
                labels = values if name in LABELS else quantile_bins(values, BINS)
                kinds, counts = np.unique(labels, return_counts=True)
                if len(kinds[counts >= 5]) < 2:
                    continue
                score = _scores(signed, np.where(np.isin(labels, kinds[counts >= 5]), labels, np.nan), found.block, signs)
                scores.append(score)
                explained = score[0] / len(errors)
                entries.append((explained / variance, Discrepancy(channel, name, float(np.sqrt(explained)), unit, 1.0)))
    if not scores:
        return []
    every = np.array(scores)
    # covariates have different numbers of groups: each statistic in units of what chance makes of it
    every = (every - every[:, 1:].mean(axis=1, keepdims=True)) / np.maximum(every[:, 1:].std(axis=1, keepdims=True), 1e-300)
    chance = np.sort(every[:, 1:].max(axis=0))
    p_values = (1.0 + RESAMPLES - np.searchsorted(chance, every[:, 0])) / (1.0 + RESAMPLES)
    best: dict[tuple[str, str], tuple[float, Discrepancy]] = {}
    for (share, entry), p in zip(entries, p_values, strict=True):
        key = (entry.channel, entry.depends_on)
        if p < CERTAIN and (key not in best or share > best[key][0]):
            best[key] = (share, dataclasses.replace(entry, p_value=float(p)))
    return [entry for _, entry in sorted(best.values(), key=lambda pair: -pair[0])]


def _scores(errors: FloatArray, labels: FloatArray, block: IntArray, signs: FloatArray) -> FloatArray:
    """Return the sum of squares (S + 1,) that groups explain: as it is, then what they explain by chance, with random signs (S, B).

    Chance has the errors about their groups' means, widened by what the means took: a dependence must not hide behind itself.
    """
    kinds = np.unique(labels[~np.isnan(labels)])
    blocks = signs.shape[1]
    wider = np.sqrt(blocks / max(1.0, blocks - len(kinds)))
    total = np.zeros(len(signs) + 1)
    for kind in kinds:
        inside = labels == kind
        mean = float(errors[inside].mean())
        sums = np.bincount(block[inside], errors[inside] - mean, blocks)
        total += np.append(mean * inside.sum(), wider * (signs @ sums)) ** 2 / inside.sum()
    return total

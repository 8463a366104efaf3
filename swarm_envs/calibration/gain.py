"""How much better the extended model predicts runs that it was not fitted to."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.drive import free_run
from swarm_envs.calibration.filtering import HEADING, PLACE, Measured
from swarm_envs.calibration.fitting import Model
from swarm_envs.calibration.log import FloatArray, Log, Track
from swarm_envs.calibration.prediction import HORIZONS, WindowErrors, rms, tracked, window_errors

RESAMPLES = 1000
"""Bootstrap resamples of the held-out groups."""


@dataclass(frozen=True)
class Gain:
    """One metric at one horizon on held-out runs."""

    metric: str
    """``position`` or ``heading``: rms of the error at the ends of the windows."""
    horizon_s: float
    unit: str
    before: float
    """With the world as it was."""
    after: float
    """With the effects, fitted to the other runs."""
    ci95: tuple[float, float]
    """Of ``before - after``, by resampling runs."""
    noise_floor: float
    """What the tracker's noise alone would give."""


def heldout_gain(log: Log, data: Measured, before: FloatArray, after: Sequence[Model]) -> list[Gain]:
    """Return the gain per metric and horizon.

    Args:
        log: The log.
        data: The same, as it was fitted; its groups are what is held out.
        before: (16,) the drive of the world as it was.
        after: For each group the model that was fitted without it.
    """
    gains = []
    plain = np.ones(2)
    for horizon in HORIZONS:
        pairs: list[tuple[WindowErrors, WindowErrors]] = []
        distance: list[FloatArray] = []
        groups: list[int] = []
        for piece, track in enumerate(piece_tracks(log, data)):
            begin, end = data.times[data.first[piece]], data.times[data.first[piece + 1] - 1]
            model = after[data.run[piece]]
            old = _inside(window_errors(before, track, horizon, plain), begin, end)
            new = _inside(window_errors(model.parameters, track, horizon, model.gains[data.robot[piece]]), begin, end)
            if len(old.starts):
                pairs.append((old, new))
                groups.append(int(data.run[piece]))
                distance.append(_driven(track, old.starts, horizon))
        if not pairs:
            continue
        noise = np.mean([model.noise for model in after], axis=0)
        way = rms(np.concatenate(distance))
        floors = {
            "position": float(np.sqrt(4 * noise[PLACE] ** 2 + (noise[HEADING] * way) ** 2)), "heading": float(np.sqrt(2) * noise[HEADING]),
        }  # fmt: skip
        for metric, unit in (("position", "m"), ("heading", "rad")):
            squares = _squares_by_group([(getattr(old, metric), getattr(new, metric)) for old, new in pairs], groups)
            was, now = np.sqrt(squares[:, :2].sum(axis=0) / squares[:, 2].sum())
            gains.append(Gain(metric, horizon, unit, float(was), float(now), _bootstrap(squares), floors[metric]))
    return gains


def piece_tracks(log: Log, data: Measured) -> list[Track]:
    """Return the track that each piece of the fitted data is from."""
    tracks = tracked(log)
    result = []
    for piece in range(len(data.robot)):
        group, robot = data.runs[data.run[piece]], data.robots[data.robot[piece]]
        result.append(next(t for t in tracks if t.robot == robot and (group == t.run or group.startswith(f"{t.run}, part "))))
    return result


def _inside(errors: WindowErrors, begin: float, end: float) -> WindowErrors:
    kept = (errors.starts >= begin) & (errors.starts <= end)
    return WindowErrors(errors.starts[kept], errors.position[kept], errors.heading[kept])


def _driven(track: Track, starts: FloatArray, horizon: float) -> FloatArray:
    """Return the distance (W,) in m from each window's start to its end, as measured."""
    first, last = np.searchsorted(track.times, starts), np.searchsorted(track.times, starts + horizon)
    return np.asarray(np.hypot(*(track.poses[np.minimum(last, len(track.times) - 1), :2] - track.poses[first, :2]).T))


def _squares_by_group(pairs: list[tuple[FloatArray, FloatArray]], groups: list[int]) -> FloatArray:
    """Return for each group (G, 3) the sums of squares before and after, and the number of windows."""
    names = sorted(set(groups))
    sums = np.zeros((len(names), 3))
    for (old, new), group in zip(pairs, groups, strict=True):
        sums[names.index(group)] += (float(np.sum(old**2)), float(np.sum(new**2)), len(old))
    return sums


def _bootstrap(squares: FloatArray) -> tuple[float, float]:
    generator = np.random.default_rng(0)
    drawn = squares[generator.integers(len(squares), size=(RESAMPLES, len(squares)))].sum(axis=1)
    change = np.sqrt(drawn[:, 0] / drawn[:, 2]) - np.sqrt(drawn[:, 1] / drawn[:, 2])
    low, high = np.quantile(change, (0.025, 0.975))
    return float(low), float(high)


def overlay(model: Model, track: Track, robot: int) -> FloatArray:
    """Return the path (T, 3) that a model drives from a track's first pose, by the commands alone."""
    return free_run(model.parameters, track, model.gains[robot]).from_pose(0, track.poses[0], slice(None))

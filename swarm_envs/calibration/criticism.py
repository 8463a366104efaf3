"""What a model gets wrong, channel by channel, and on what that depends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import f_oneway, ttest_1samp

from swarm_envs.calibration.contact import may_touch
from swarm_envs.calibration.drive import free_run
from swarm_envs.calibration.fitting import Model
from swarm_envs.calibration.log import BoolArray, FloatArray, Log, Track
from swarm_envs.calibration.prediction import tracked

SPAN = 0.5
"""Length in s of the windows whose errors are looked at; they do not overlap."""
CHANNELS = {"forward speed": "m/s", "lateral slip": "m/s", "turn rate": "rad/s"}
"""What may depart from zero, and its unit."""
BINS = 8
"""Groups of equally many windows along a variable."""
CERTAIN = 1e-3
"""Greatest p-value, corrected for the number of tests, at which a dependence is reported."""


@dataclass(frozen=True)
class Residuals:
    """Measured minus predicted motion over W short windows, and the circumstances of each."""

    errors: FloatArray
    """(W, 3) in the order of :data:`CHANNELS`."""
    circumstances: dict[str, FloatArray]
    """(W,) each; ``place`` and ``robot`` are labels, the others numbers."""


@dataclass(frozen=True)
class Discrepancy:
    """A channel that departs from zero."""

    channel: str
    depends_on: str
    """A circumstance, or ``nothing``: the departure is the same everywhere."""
    size: float
    """Root mean square of the departures explained by the circumstance, or the mean."""
    unit: str
    p_value: float
    """Corrected for the number of tests."""


def residuals(log: Log, model: Model, robots: tuple[str, ...]) -> Residuals:
    """Return what a model gets wrong in short windows that start at measured poses."""
    tracks = tracked(log)
    parts = [
        _of_track(track, model, robots.index(track.robot), touching) for track, touching in zip(tracks, may_touch(log, tracks), strict=True)
    ]
    parts = [part for part in parts if len(part.errors)]
    if not parts:
        return Residuals(np.empty((0, 3)), {})
    circumstances = {name: np.concatenate([part.circumstances[name] for part in parts]) for name in parts[0].circumstances}
    x, y = circumstances.pop("x"), circumstances.pop("y")
    circumstances["place"] = _quantile_bins(x, 4) * 4 + _quantile_bins(y, 4)
    return Residuals(np.concatenate([part.errors for part in parts]), circumstances)


def _of_track(track: Track, model: Model, robot: int, touching: BoolArray) -> Residuals:
    wanted = np.arange(track.times[0], track.times[-1] - SPAN, SPAN)
    first, last = np.searchsorted(track.times, wanted), np.searchsorted(track.times, wanted + SPAN)
    good = (last < len(track.times)) & (np.abs(track.times[np.minimum(last, len(track.times) - 1)] - wanted - SPAN) < 0.1 * SPAN)
    good &= np.cumsum(touching)[np.minimum(last, len(touching) - 1)] == np.cumsum(touching)[first]
    first, last = first[good], last[good]
    run = free_run(model.parameters, track, model.gains[robot])
    span = track.times[last] - track.times[first]
    gone = run.path[last, :2] - run.path[first, :2]
    turn = track.poses[first, 2] - run.marker_yaw - run.path[first, 2]
    c, s = np.cos(turn), np.sin(turn)
    moved = np.column_stack([c * gone[:, 0] - s * gone[:, 1], s * gone[:, 0] + c * gone[:, 1]]) + run.drift[last] - run.drift[first]
    missing = (track.poses[last, :2] - track.poses[first, :2] - moved) / span[:, None]
    way = 0.5 * (track.poses[first, 2] + track.poses[last, 2]) - run.marker_yaw
    turned = (track.poses[last, 2] - track.poses[first, 2] - (run.path[last, 2] - run.path[first, 2])) / span
    errors = np.column_stack([
        missing[:, 0] * np.cos(way) + missing[:, 1] * np.sin(way), missing[:, 1] * np.cos(way) - missing[:, 0] * np.sin(way), turned,
    ])  # fmt: skip
    now = track.times[first]
    command = np.searchsorted(track.command_times, now + 0.5 * SPAN, side="right") - 1
    given = np.where((command >= 0)[:, None], track.commands[np.maximum(command, 0)], 0.0)
    moving = np.any(track.commands != 0.0, axis=1)
    starts = track.command_times[np.append(moving[:1], moving[1:] & ~moving[:-1])]
    started = np.searchsorted(starts, now, side="right") - 1
    since = np.where(started >= 0, now - starts[np.maximum(started, 0)], 0.0) if len(starts) else np.zeros(len(now))
    # errors while a robot is meant to stand say little of how it drives
    drives = np.any(given != 0.0, axis=1)
    circumstances = {
        "commanded speed": given[:, 0], "commanded turn rate": given[:, 1], "time since a start": since, "time in the run": now,
        "heading": way % (2 * np.pi), "x": track.poses[first, 0], "y": track.poses[first, 1], "robot": np.full(len(now), float(robot)),
    }  # fmt: skip
    return Residuals(errors[drives], {name: value[drives] for name, value in circumstances.items()})


def _quantile_bins(values: FloatArray, count: int) -> FloatArray:
    """Return the bin (W,) of each value among ``count`` of equally many; few distinct values have one each."""
    distinct = np.unique(np.round(values, 6))
    if len(distinct) <= count:
        return np.searchsorted(distinct, np.round(values, 6)).astype(float)
    edges = np.unique(np.quantile(values, np.linspace(0, 1, count + 1)[1:-1]))
    return np.searchsorted(edges, values, side="right").astype(float)


def criticise(found: Residuals) -> list[Discrepancy]:
    """Return the departures from zero that are certain, the largest share of the variance first."""
    tests: list[tuple[float, Discrepancy]] = []
    number = len(CHANNELS) * (len(found.circumstances) + 1)
    for k, (channel, unit) in enumerate(CHANNELS.items()):
        errors = found.errors[:, k]
        if len(errors) < 20 or np.ptp(errors) == 0.0:
            continue
        # a few wild windows must neither hide a dependence nor make one
        limit = 6 * 1.4826 * float(np.median(np.abs(errors - np.median(errors)))) + 1e-12
        errors = np.clip(errors, np.median(errors) - limit, np.median(errors) + limit)
        mean = float(errors.mean())
        p = float(ttest_1samp(errors, 0.0).pvalue) * number
        tests.append((mean**2 / float(np.mean(errors**2)), Discrepancy(channel, "nothing", abs(mean), unit, min(1.0, p))))
        for name, values in found.circumstances.items():
            labels = values if name in ("place", "robot") else _quantile_bins(values, BINS)
            groups = [errors[labels == label] for label in np.unique(labels)]
            groups = [group for group in groups if len(group) >= 5]
            if len(groups) < 2:
                continue
            p = float(f_oneway(*groups).pvalue) * number
            every = np.concatenate(groups)
            explained = sum(len(group) * (group.mean() - every.mean()) ** 2 for group in groups) / len(every)
            tests.append((float(explained / np.var(every)), Discrepancy(channel, name, float(np.sqrt(explained)), unit, min(1.0, p))))
    tests.sort(key=lambda entry: -entry[0])
    return [test for _, test in tests if test.p_value < CERTAIN]

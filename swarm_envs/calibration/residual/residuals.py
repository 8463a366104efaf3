"""What a model gets wrong over short windows, channel by channel, and the covariates of each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.arrays import BoolArray, FloatArray, IntArray
from swarm_envs.calibration.drive.fitting import BLOCK, Model
from swarm_envs.calibration.drive.lost_commands import without_lost_commands
from swarm_envs.calibration.drive.motion import free_run
from swarm_envs.calibration.logs.log import Log, Track, tracked
from swarm_envs.calibration.logs.near_contact import may_touch

SPAN = 0.5
"""Length in s of the windows whose errors are looked at; they do not overlap."""
CHANNELS = {"forward speed": "m/s", "lateral slip": "m/s", "turn rate": "rad/s"}
"""What may depart from zero, and its unit."""
WINSORISED_AT = 0.99
"""Share of errors that count in full; those beyond are cut to 1.5 times the quantile."""
FEW_RUNS = 5
"""With fewer runs, parts of :data:`PART` s are what is held out."""
PART = 20.0
"""Length in s of such parts."""
MOMENTS = 5
"""Moments through a window at which place and motion are noted."""
LABELS = ("place", "robot")
"""Covariates that are labels and not numbers."""


@dataclass(frozen=True)
class Residuals:
    """Measured minus predicted motion over W short windows, and the covariates of each."""

    errors: FloatArray
    """(W, 3) in the order of :data:`CHANNELS`."""
    covariates: dict[str, FloatArray]
    """(W,) each; those in :data:`LABELS` are labels, the others numbers."""
    where: FloatArray
    """(W, 2) place in m at the middle of the window."""
    motion: FloatArray
    """(W, 2) predicted forward speed in m/s and turn rate in rad/s."""
    along: FloatArray
    """(W, T, 4) at moments through the window: measured x and y in m, predicted forward speed in m/s and turn rate in rad/s."""
    block: IntArray
    """(W,) windows of one block may err alike; blocks err independently."""
    group: IntArray
    """(W,) windows of one group are held out together: a run, or a part of one where runs are few."""


def residuals(log: Log, model: Model, robots: tuple[str, ...]) -> Residuals:
    """Return what a model gets wrong in short windows that start at measured poses."""
    tracks = tracked(log)
    parts = [
        _of_track(without_lost_commands(track, model, robots.index(track.robot)), model, robots.index(track.robot), touching)
        for track, touching in zip(tracks, may_touch(log, tracks), strict=True)
    ]
    groups = held_out_together(log)
    if not sum(len(part.errors) for part in parts):
        nobody = np.empty(0, np.int64)
        return Residuals(np.empty((0, 3)), {}, np.empty((0, 2)), np.empty((0, 2)), np.empty((0, MOMENTS, 4)), nobody, nobody)
    times = [part.covariates["time in the run"] for part in parts]
    covariates = {name: np.concatenate([part.covariates[name] for part in parts]) for name in parts[0].covariates}
    where = np.concatenate([part.where for part in parts])
    covariates["place"] = quantile_bins(where[:, 0], 4) * 4 + quantile_bins(where[:, 1], 4)
    keys = [[(number, int(t // BLOCK)) for t in part] for number, part in enumerate(times)]
    held = [[group_of(groups, track, float(t)) for t in part] for track, part in zip(tracks, times, strict=True)]
    return Residuals(
        np.concatenate([part.errors for part in parts]), covariates, where, np.concatenate([part.motion for part in parts]),
        np.concatenate([part.along for part in parts]),
        _numbered([key for part in keys for key in part]), np.array([g for part in held for g in part], np.int64),
    )  # fmt: skip


def held_out_together(log: Log) -> dict[tuple[str, int], int]:
    """Return the number of each group that is held out together, by run and part of the run."""
    tracks = tracked(log)
    runs = tuple(dict.fromkeys(track.run for track in tracks))
    if len(runs) >= FEW_RUNS:
        return {(run, -1): number for number, run in enumerate(runs)}
    longest = {run: max(float(track.times[-1]) for track in tracks if track.run == run) for run in runs}
    keys = [(run, part) for run in runs for part in range(int(longest[run] // PART) + 1)]
    return {key: number for number, key in enumerate(keys)}


def group_of(groups: dict[tuple[str, int], int], track: Track, time: float) -> int:
    """Return the group of a time in a track."""
    return groups[track.run, -1] if (track.run, -1) in groups else groups[track.run, max(0, int(time // PART))]


def _numbered(keys: list[tuple[int, int]]) -> IntArray:
    known = {key: number for number, key in enumerate(dict.fromkeys(keys))}
    return np.array([known[key] for key in keys], np.int64)


def _of_track(track: Track, model: Model, robot: int, touching: BoolArray) -> Residuals:
    wanted = np.arange(track.times[0], track.times[-1] - SPAN, SPAN)
    first, last = np.searchsorted(track.times, wanted), np.searchsorted(track.times, wanted + SPAN)
    good = (last < len(track.times)) & (np.abs(track.times[np.minimum(last, len(track.times) - 1)] - wanted - SPAN) < 0.1 * SPAN)
    good &= np.cumsum(touching)[np.minimum(last, len(touching) - 1)] == np.cumsum(touching)[first]
    first, last = first[good], last[good]
    run = free_run(model.parameters, track, model.gains[robot])
    span = track.times[last] - track.times[first]
    way = 0.5 * (track.poses[first, 2] + track.poses[last, 2]) - run.marker_yaw
    # each displacement is seen from its own mean heading: a wrong turn rate is then no slip
    gone = _seen_from(way, track.poses[last, :2] - track.poses[first, :2] - (run.drift[last] - run.drift[first]))
    expected = _seen_from(0.5 * (run.path[first, 2] + run.path[last, 2]), run.path[last, :2] - run.path[first, :2])
    turned = run.path[last, 2] - run.path[first, 2]
    errors = np.column_stack([gone - expected, track.poses[last, 2] - track.poses[first, 2] - turned]) / span[:, None]
    now = track.times[first]
    given, since = situation(track, now + 0.5 * SPAN)
    # errors while a robot is meant to stand say little of how it drives
    drives = np.any(given != 0.0, axis=1)
    covariates = {
        "commanded speed": given[:, 0], "commanded turn rate": given[:, 1], "time since a start": since, "time in the run": now,
        "heading": way % (2 * np.pi), "robot": np.full(len(now), float(robot)),
    }  # fmt: skip
    nowhere = np.zeros(int(drives.sum()), np.int64)
    return Residuals(
        errors[drives], {name: value[drives] for name, value in covariates.items()},
        0.5 * (track.poses[first, :2] + track.poses[last, :2])[drives], (np.column_stack([expected[:, 0], turned]) / span[:, None])[drives],
        _through(track, run.path, first[drives], last[drives]), nowhere, nowhere,
    )  # fmt: skip


def _through(track: Track, path: FloatArray, first: IntArray, last: IntArray) -> FloatArray:
    """Return measured places and predicted motion (W, T, 4) at moments through windows; motion ahead is as seen over the whole window."""
    begin, span = track.times[first][:, None], (track.times[last] - track.times[first])[:, None]
    inside = begin + span * (np.arange(MOMENTS) + 0.5) / MOMENTS
    edges = begin + span * np.arange(MOMENTS + 1) / MOMENTS
    steps = np.diff(np.stack([np.interp(edges, track.times, column) for column in path.T], axis=-1), axis=1) / (span[..., None] / MOMENTS)
    way = 0.5 * (path[first, 2] + path[last, 2])[:, None]
    ahead = np.cos(way) * steps[..., 0] + np.sin(way) * steps[..., 1]
    places = [np.interp(inside, track.times, track.poses[:, k]) for k in range(2)]
    return np.stack([*places, ahead, steps[..., 2]], axis=-1)


def _seen_from(heading: FloatArray, gone: FloatArray) -> FloatArray:
    """Return displacements (W, 2) along and across headings (W,)."""
    c, s = np.cos(heading), np.sin(heading)
    return np.column_stack([c * gone[:, 0] + s * gone[:, 1], c * gone[:, 1] - s * gone[:, 0]])


def situation(track: Track, times: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the command in force (W, 2) at some times and the time (W,) in s since the last start from rest."""
    command = np.searchsorted(track.command_times, times, side="right") - 1
    given = np.where((command >= 0)[:, None], track.commands[np.maximum(command, 0)], 0.0)
    moving = np.any(track.commands != 0.0, axis=1)
    starts = track.command_times[np.append(moving[:1], moving[1:] & ~moving[:-1])]
    started = np.searchsorted(starts, times, side="right") - 1
    since = np.where(started >= 0, times - starts[np.maximum(started, 0)], 0.0) if len(starts) else np.zeros(len(times))
    return given, since


def quantile_bins(values: FloatArray, count: int) -> FloatArray:
    """Return the bin (W,) of each value among ``count`` of equally many; few distinct values have one each."""
    distinct = np.unique(np.round(values, 6))
    if len(distinct) <= count:
        return np.searchsorted(distinct, np.round(values, 6)).astype(float)
    edges = np.unique(np.quantile(values, np.linspace(0, 1, count + 1)[1:-1]))
    return np.searchsorted(edges, values, side="right").astype(float)


def winsorised(errors: FloatArray) -> FloatArray:
    """Return errors (W,) with the few wild ones cut, which must neither hide a dependence nor make one."""
    limit = 1.5 * float(np.quantile(np.abs(errors), WINSORISED_AT)) + 1e-12
    return np.clip(errors, -limit, limit)

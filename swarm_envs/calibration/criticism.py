"""What a model gets wrong, channel by channel, and on what that depends."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.contact import may_touch
from swarm_envs.calibration.drive import COMMAND_LOSS, DEAD_TIME, IntArray, free_run, target
from swarm_envs.calibration.fitting import BLOCK, Model
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
RESAMPLES = 2999
"""Random signs given to the blocks: the smallest p-value is one in so many and one."""
WILD = 0.99
"""Share of errors that count in full; those beyond are cut to 1.5 times the quantile."""
FEW_RUNS = 5
"""With fewer runs, parts of :data:`PART` s are what is held out."""
PART = 20.0
"""Length in s of such parts."""
MOMENTS = 5
"""Moments through a window at which place and motion are noted."""
LABELS = ("place", "robot")
"""Circumstances that are labels and not numbers."""


@dataclass(frozen=True)
class Residuals:
    """Measured minus predicted motion over W short windows, and the circumstances of each."""

    errors: FloatArray
    """(W, 3) in the order of :data:`CHANNELS`."""
    circumstances: dict[str, FloatArray]
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
    """Corrected for the number of tests, and for windows that err alike."""


def residuals(log: Log, model: Model, robots: tuple[str, ...]) -> Residuals:
    """Return what a model gets wrong in short windows that start at measured poses."""
    tracks = tracked(log)
    parts = [
        _of_track(delivered(track, model, robots.index(track.robot)), model, robots.index(track.robot), touching)
        for track, touching in zip(tracks, may_touch(log, tracks), strict=True)
    ]
    groups = held_out_together(log)
    if not sum(len(part.errors) for part in parts):
        nobody = np.empty(0, np.int64)
        return Residuals(np.empty((0, 3)), {}, np.empty((0, 2)), np.empty((0, 2)), np.empty((0, MOMENTS, 4)), nobody, nobody)
    times = [part.circumstances["time in the run"] for part in parts]
    circumstances = {name: np.concatenate([part.circumstances[name] for part in parts]) for name in parts[0].circumstances}
    where = np.concatenate([part.where for part in parts])
    circumstances["place"] = _quantile_bins(where[:, 0], 4) * 4 + _quantile_bins(where[:, 1], 4)
    keys = [[(number, int(t // BLOCK)) for t in part] for number, part in enumerate(times)]
    held = [[group_of(groups, track, float(t)) for t in part] for track, part in zip(tracks, times, strict=True)]
    return Residuals(
        np.concatenate([part.errors for part in parts]), circumstances, where, np.concatenate([part.motion for part in parts]),
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


def delivered(track: Track, model: Model, robot: int) -> Track:
    """Return a track without the commands that seem to have been lost, where the model says that some are.

    What a lost command does is chance: left in, it would look like an error that depends on the command.
    """
    p = model.parameters
    if p[COMMAND_LOSS] <= 0.0 or not len(track.commands):
        return track
    gain, kept = model.gains[robot], []
    begins = track.command_times + p[DEAD_TIME]
    ends = np.minimum(np.append(begins[1:], track.times[-1]), begins + 1.0)
    held = (0.0, 0.0)
    for number, (v, omega) in enumerate(track.commands.tolist()):
        first, last = np.searchsorted(track.times, (begins[number], ends[number]))
        if (v, omega) != held and 0 < first < last - 1 and last < len(track.times):
            span = track.times[last] - track.times[first]
            heading = 0.5 * (track.poses[first, 2] + track.poses[last, 2])
            gone = track.poses[last, :2] - track.poses[first, :2]
            moved = np.array([gone @ (np.cos(heading), np.sin(heading)), track.poses[last, 2] - track.poses[first, 2]]) / span
            # a rim's breadth makes speeds and turn rates alike
            misses = [
                np.abs((moved - target(p, gain, asked[0], asked[1], float(begins[number]))) * (1.0, 0.05)).sum()
                for asked in ((v, omega), held)
            ]
            if misses[1] < misses[0]:
                continue
        kept.append(number)
        held = (v, omega)
    return dataclasses.replace(track, command_times=track.command_times[kept], commands=track.commands[kept])


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
    circumstances = {
        "commanded speed": given[:, 0], "commanded turn rate": given[:, 1], "time since a start": since, "time in the run": now,
        "heading": way % (2 * np.pi), "robot": np.full(len(now), float(robot)),
    }  # fmt: skip
    nowhere = np.zeros(int(drives.sum()), np.int64)
    return Residuals(
        errors[drives], {name: value[drives] for name, value in circumstances.items()},
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


def _quantile_bins(values: FloatArray, count: int) -> FloatArray:
    """Return the bin (W,) of each value among ``count`` of equally many; few distinct values have one each."""
    distinct = np.unique(np.round(values, 6))
    if len(distinct) <= count:
        return np.searchsorted(distinct, np.round(values, 6)).astype(float)
    edges = np.unique(np.quantile(values, np.linspace(0, 1, count + 1)[1:-1]))
    return np.searchsorted(edges, values, side="right").astype(float)


def tamed(errors: FloatArray) -> FloatArray:
    """Return errors (W,) with the few wild ones cut, which must neither hide a dependence nor make one."""
    limit = 1.5 * float(np.quantile(np.abs(errors), WILD)) + 1e-12
    return np.clip(errors, -limit, limit)


def criticise(found: Residuals) -> list[Discrepancy]:
    """Return the departures from zero that are certain, the largest share of the variance first.

    Each channel is grouped by each circumstance, as it is and in the direction of travel. Blocks of windows are given random signs:
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
        errors = tamed(found.errors[:, k])
        if np.ptp(errors) == 0.0:
            continue
        variance = float(np.mean(errors**2))
        for carrier in (np.ones(len(errors)), travel):
            carried = errors * carrier
            entries.append((float(carried.mean()) ** 2 / variance, Discrepancy(channel, "nothing", abs(float(carried.mean())), unit, 1.0)))
            scores.append(_scores(carried, np.zeros(len(errors)), found.block, signs))
            carried = carried - carried.mean()
            for name, values in found.circumstances.items():
                labels = values if name in LABELS else _quantile_bins(values, BINS)
                kinds, counts = np.unique(labels, return_counts=True)
                if len(kinds[counts >= 5]) < 2:
                    continue
                score = _scores(carried, np.where(np.isin(labels, kinds[counts >= 5]), labels, np.nan), found.block, signs)
                scores.append(score)
                explained = score[0] / len(errors)
                entries.append((explained / variance, Discrepancy(channel, name, float(np.sqrt(explained)), unit, 1.0)))
    if not scores:
        return []
    every = np.array(scores)
    # circumstances have different numbers of groups: each statistic in units of what chance makes of it
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

    Chance has the errors about their groups' means, widened by what the means took: a dependence shall not hide behind itself.
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

"""How much better the extended model predicts runs that it was not fitted to."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from swarm_envs.calibration.arrays import BoolArray, FloatArray
from swarm_envs.calibration.drive.fitting import Model
from swarm_envs.calibration.drive.measured import Measured, run_of
from swarm_envs.calibration.drive.noise import HEADING, PLACE
from swarm_envs.calibration.logs.log import Log, Track, tracked
from swarm_envs.calibration.prediction.evaluation import predictor
from swarm_envs.calibration.prediction.reference import reference_errors
from swarm_envs.calibration.prediction.windows import HORIZONS, WindowErrors, rms
from swarm_envs.calibration.validation.gain import Gain, bootstrap
from swarm_envs.worlds import WorldSpec


def heldout_gain(log: Log, data: Measured, before: FloatArray, after: Sequence[Model], world: WorldSpec, extended: WorldSpec) -> list[Gain]:
    """Return the gain per metric and horizon.

    Args:
        log: The log.
        data: The same, as it was fitted; its groups are what is held out.
        before: The drive of the world as it was.
        after: For each group the model that was fitted without it.
        world: The world as it was; where the log has an outline, its bodies and contact meet the walls in predictions of before.
        extended: The world with the named effects, whose bodies and contact do so in those of after.
    """
    gains = []
    was = predictor(log, world, before)
    # groups of one fold share their model
    folds = {id(model): model for model in after}
    runs_of = {key: [run_of(name) for name, model in zip(data.runs, after, strict=True) if id(model) == key] for key in folds}
    now = {
        key: predictor(log, extended, model.parameters, dict(zip(data.robots, model.gains, strict=True)), runs_of[key])
        for key, model in folds.items()
    }
    turning = _turning(data)
    references = _references(log, data)
    for horizon in HORIZONS:
        pairs: list[tuple[WindowErrors, WindowErrors]] = []
        distance: list[FloatArray] = []
        groups: list[int] = []
        for piece, track in enumerate(piece_tracks(log, data)):
            begin, end = data.times[data.first[piece]], data.times[data.first[piece + 1] - 1]
            old = _inside(was(track, horizon), begin, end)
            new = _inside(now[id(after[data.run[piece]])](track, horizon), begin, end)
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
            strata = turning[sorted(set(groups))]
            first, then = np.sqrt(squares[:, :2].sum(axis=0) / squares[:, 2].sum())
            interval, reference = bootstrap(squares, strata), references.get(horizon, {}).get(metric)
            gains.append(Gain(metric, horizon, unit, float(first), float(then), interval, floors[metric], reference))
    return gains


def _references(log: Log, data: Measured) -> dict[float, dict[str, float]]:
    """Return the reference's errors by horizon and metric, computed on one thread: over small trees threads wait more than they work."""
    from sklearn import ensemble  # noqa: F401  # a limit holds for libraries that are loaded
    from threadpoolctl import threadpool_limits

    with threadpool_limits(1, "openmp"):
        return reference_errors(log, data)


def piece_tracks(log: Log, data: Measured) -> list[Track]:
    """Return the track that each piece of the fitted data is from."""
    tracks = tracked(log)
    result = []
    for piece in range(len(data.robot)):
        group, robot = data.runs[data.run[piece]], data.robots[data.robot[piece]]
        result.append(next(t for t in tracks if t.robot == robot and (run_of(group) == t.run)))
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


def _turning(data: Measured) -> BoolArray:
    """Return for each group whether a robot was told to turn in it.

    A log has few programmes of commands, chosen and not drawn. Resamples that leave out all runs with turns would tell of other drives.
    """
    turning = np.zeros(len(data.runs), bool)
    for piece, group in enumerate(data.run):
        commands = slice(data.command_first[piece], data.command_first[piece + 1])
        times, omega = data.command_times[commands], data.commands[commands, 1]
        begin, end = data.times[data.first[piece]], data.times[data.first[piece + 1] - 1]
        turning[group] |= bool(np.any((omega != 0.0) & (times < end) & (np.append(times[1:], np.inf) > begin)))
    return turning

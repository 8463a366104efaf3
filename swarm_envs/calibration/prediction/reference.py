"""A reference that no parametric model beats easily: a flexible regression of motion on recent commands, knowing no mechanics.

The motion of each short step, seen from the robot, is a linear function of the commands of the last second, which any delay and lag
are, and on top of that boosted trees of the same, of the wheels' speeds, the time in the run and the robot. It is trained on other
runs and predicts freely: steps are chained, measured poses are seen at the start of a window only.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from swarm_envs.calibration.arrays import BoolArray, FloatArray
from swarm_envs.calibration.drive.measured import Measured
from swarm_envs.calibration.logs.log import Log, Track, tracked
from swarm_envs.calibration.logs.near_contact import may_touch
from swarm_envs.calibration.prediction.windows import HORIZONS, rms, windows

STEP = 0.2
"""Time in s of one step."""
PAST = 1.0
"""Commands are known from so long before a step, s."""
BIN = 0.05
"""Width in s of the intervals over which commands are averaged."""
WHEEL_BASE = 0.06
"""Distance in m that makes rim speeds of commands; only where trees split depends on it."""
PENALTY = 1e-3
"""Of the linear part, as a share of its inputs' variance."""
FOLDS = 6
"""Parts of the runs, each predicted by what was trained on the others; those of :attr:`Identified.without`."""
MOST_STEPS = 20000
"""Steps that are trained on at most."""


def reference_errors(log: Log, data: Measured, horizons: Sequence[float] = HORIZONS) -> dict[float, dict[str, float]]:
    """Return the reference's errors on held-out runs, over the windows of :func:`swarm_envs.calibration.validation.heldout.heldout_gain`.

    Args:
        log: The log.
        data: The same, as it was fitted: its groups are what is held out, in the same folds as the extended model's.
        horizons: Lengths of the windows in s.

    Returns:
        For each horizon the rms at the windows' ends as ``position`` in m and ``heading`` in rad. A horizon that no run reaches, and
        everything where there is only one group to train on, is left out.
    """
    groups = len(data.runs)
    folds = min(FOLDS, groups)
    if folds < 2:
        return {}
    tracks = {(track.run, track.robot): track for track in tracked(log)}
    touching = dict(zip(tracks, may_touch(log, list(tracks.values())), strict=True))
    pieces = [_piece(data, piece, tracks) for piece in range(len(data.robot))]
    steps = [_steps(tracks[key], begin, end, data.robots.index(key[1]), touching[key]) for key, begin, end in pieces]
    missed: dict[float, list[FloatArray]] = {horizon: [] for horizon in horizons}
    for fold in range(folds):
        inside = [int(group) % folds == fold for group in data.run]
        model = _train([step for step, out in zip(steps, inside, strict=True) if not out])
        for (key, begin, end), out in zip(pieces, inside, strict=True):
            if out:
                track = tracks[key]
                path = _path(model, track, data.robots.index(key[1]))
                for horizon in horizons:
                    first, last = windows(track.times, horizon)
                    kept = (track.times[first] >= begin) & (track.times[first] <= end)
                    missed[horizon].append(_missed(path, track, first[kept], last[kept]))
    every = {horizon: np.concatenate(parts) for horizon, parts in missed.items() if sum(map(len, parts))}
    return {horizon: {"position": rms(errors[:, 0]), "heading": rms(errors[:, 1])} for horizon, errors in every.items()}


def _piece(data: Measured, piece: int, tracks: dict[tuple[str, str], Track]) -> tuple[tuple[str, str], float, float]:
    """Return the track of a piece, and when the piece begins and ends."""
    group, robot = data.runs[data.run[piece]], data.robots[data.robot[piece]]
    run = group if (group, robot) in tracks else group.rpartition(", part ")[0]
    return (run, robot), float(data.times[data.first[piece]]), float(data.times[data.first[piece + 1] - 1])


def _steps(track: Track, begin: float, end: float, robot: int, touching: BoolArray) -> tuple[FloatArray, FloatArray]:
    """Return inputs (S, F) and measured motion (S, 3) of the steps of a part of a track that is measured and touches nothing."""
    # steps begin anywhere: half a step apart they tell more of when a command acts
    starts = np.arange(begin, end - STEP, 0.5 * STEP)
    first, last = np.searchsorted(track.times, starts), np.searchsorted(track.times, starts + STEP)
    good = (last < len(track.times)) & (last > first)
    first, last = first[good], last[good]
    span = track.times[last] - track.times[first]
    good = (np.abs(span - STEP) < 0.25 * STEP) & (np.cumsum(touching)[last] == np.cumsum(touching)[first])
    first, last, span = first[good], last[good], span[good]
    gone = track.poses[last, :2] - track.poses[first, :2]
    turned = track.poses[last, 2] - track.poses[first, 2]
    heading = track.poses[first, 2] + 0.5 * turned
    c, s = np.cos(heading), np.sin(heading)
    motion = np.column_stack([c * gone[:, 0] + s * gone[:, 1], c * gone[:, 1] - s * gone[:, 0], turned]) * (STEP / span)[:, None]
    return _inputs(track, track.times[first], robot), motion


def _inputs(track: Track, starts: FloatArray, robot: int) -> FloatArray:
    """Return what is known of steps (S, F): mean commands in bins of the past and the step, the time in the run, the robot."""
    edges = starts[:, None] + np.arange(-PAST, STEP + 1e-9, BIN)
    ends = np.append(track.command_times[1:], max(float(edges.max(initial=0.0)), float(track.command_times[-1])) + 1.0)
    sums = np.vstack([np.zeros((1, 2)), np.cumsum(track.commands * (ends - track.command_times)[:, None], axis=0)])
    times = np.append(track.command_times, ends[-1])
    means = [np.diff(np.interp(edges, times, sums[:, k], left=0.0), axis=1) / BIN for k in range(2)]
    return np.column_stack([*means, starts, np.full(len(starts), float(robot))])


def _train(steps: Sequence[tuple[FloatArray, FloatArray]]) -> Any:
    """Return a function from inputs (S, F) to motion (S, 3)."""
    from sklearn.ensemble import HistGradientBoostingRegressor

    inputs, motion = np.concatenate([step[0] for step in steps]), np.concatenate([step[1] for step in steps])
    kept = slice(None, None, max(1, len(inputs) // MOST_STEPS))
    inputs, motion = inputs[kept], motion[kept]
    scale = np.sqrt(np.mean(_linear_inputs(inputs) ** 2, axis=0)) + 1e-9
    design = _linear_inputs(inputs) / scale
    weights = np.linalg.solve(design.T @ design + PENALTY * len(design) * np.eye(design.shape[1]), design.T @ motion)
    left = motion - design @ weights
    trees = [
        HistGradientBoostingRegressor(max_iter=150, learning_rate=0.08, max_leaf_nodes=16, min_samples_leaf=20, random_state=0).fit(
            _tree_inputs(inputs), left[:, k]
        )
        for k in range(3)
    ]

    def predict(given: FloatArray) -> FloatArray:
        known = _tree_inputs(given)
        return np.asarray(_linear_inputs(given) / scale @ weights + np.column_stack([tree.predict(known) for tree in trees]))

    return predict


def _linear_inputs(inputs: FloatArray) -> FloatArray:
    """Return the inputs of the linear part: commands, and their falling off through the run."""
    commands = inputs[:, :-2]
    return np.column_stack([commands, commands * inputs[:, -2:-1]])


def _tree_inputs(inputs: FloatArray) -> FloatArray:
    """Return the inputs of the trees (S, 18): mean commands and rim speeds of some spans, time and robot."""
    bins = (inputs.shape[1] - 2) // 2
    v, omega = inputs[:, :bins], inputs[:, bins : 2 * bins]
    spans = (slice(0, bins // 2), slice(bins // 2, -8), slice(-8, -4), slice(-4, None))
    means = np.column_stack([part[:, span].mean(axis=1) for part in (v, omega) for span in spans])
    rims = np.column_stack([
        v[:, span].mean(axis=1) + side * 0.5 * WHEEL_BASE * omega[:, span].mean(axis=1) for side in (-1, 1) for span in spans
    ])  # fmt: skip
    return np.column_stack([means, rims, inputs[:, -2:]])


def _path(model: Any, track: Track, robot: int) -> FloatArray:
    """Return the path (T, 3) at a track's times, from the origin, by the commands alone."""
    grid = np.arange(track.times[0], track.times[-1] + STEP, STEP)
    motion = model(_inputs(track, grid, robot))
    heading = np.concatenate([[0.0], np.cumsum(motion[:, 2])])
    middle = heading[:-1] + 0.5 * motion[:, 2]
    c, s = np.cos(middle), np.sin(middle)
    steps = np.column_stack([c * motion[:, 0] - s * motion[:, 1], s * motion[:, 0] + c * motion[:, 1]])
    path = np.column_stack([np.vstack([np.zeros((1, 2)), np.cumsum(steps, axis=0)]), heading])
    times = np.append(grid, grid[-1] + STEP)
    return np.column_stack([np.interp(track.times, times, path[:, k]) for k in range(3)])


def _missed(path: FloatArray, track: Track, first: Any, last: Any) -> FloatArray:
    """Return the errors (W, 2) in m and rad at the ends of windows."""
    turn = track.poses[first, 2] - path[first, 2]
    gone = path[last, :2] - path[first, :2]
    c, s = np.cos(turn), np.sin(turn)
    moved = np.column_stack([c * gone[:, 0] - s * gone[:, 1], s * gone[:, 0] + c * gone[:, 1]])
    place = np.hypot(*(track.poses[first, :2] + moved - track.poses[last, :2]).T)
    turned = path[last, 2] - path[first, 2] - (track.poses[last, 2] - track.poses[first, 2])
    return np.column_stack([place, (turned + np.pi) % (2 * np.pi) - np.pi])

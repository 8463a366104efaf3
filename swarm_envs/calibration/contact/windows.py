"""Windows of a log in which robots may touch each other or a wall: where they began, what they were told, and where they ended."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.logs.log import Log, Track
from swarm_envs.calibration.logs.near_contact import may_touch

SPAN = 1.0
"""Length in s of the windows that are simulated."""
TICK = 0.02
"""Tick in s with which they are."""
MOST = 400
"""Windows at most."""
ENOUGH = 20
"""Windows with robots near each other or a wall, without which nothing is said about contact."""


@dataclass(frozen=True)
class Windows:
    """W windows of R robots."""

    start: FloatArray
    """(W, R, 3) measured poses."""
    end: FloatArray
    """(W, R, 3) measured poses, SPAN s later."""
    near: FloatArray
    """(W, R) whether the robot may touch something in the window."""
    commands: FloatArray
    """(T, W, R, 2) mean commands of each tick."""
    run: FloatArray
    """(W,) index of the run."""


def contact_windows(log: Log) -> Windows | None:
    """Return the windows in which something may touch, or None where there are too few."""
    known = {(track.run, track.robot): flags for track, flags in zip(log.tracked, may_touch(log, log.tracked), strict=True)}
    runs = [[track for track in log.tracked if track.run == run] for run in log.runs]
    robots = max((len(tracks) for tracks in runs), default=0)
    starts, ends, near, commands, numbers = [], [], [], [], []
    for number, tracks in enumerate(runs):
        if len(tracks) != robots or not tracks:
            continue
        begin, end = max(track.times[0] for track in tracks), min(track.times[-1] for track in tracks)
        for at in np.arange(begin, end - SPAN, SPAN):
            touches = [bool(known[t.run, t.robot][(t.times >= at) & (t.times <= at + SPAN)].any()) for t in tracks]
            if any(touches):
                starts.append([_pose(track, at) for track in tracks])
                ends.append([_pose(track, at + SPAN) for track in tracks])
                near.append(touches)
                commands.append([_mean_commands(track, at) for track in tracks])
                numbers.append(number)
    if len(starts) < ENOUGH:
        return None
    kept = np.unique(np.linspace(0, len(starts) - 1, min(MOST, len(starts))).astype(int))
    return Windows(
        np.array(starts)[kept], np.array(ends)[kept], np.array(near, float)[kept],
        np.ascontiguousarray(np.array(commands)[kept].transpose(2, 0, 1, 3)), np.array(numbers, float)[kept],
    )  # fmt: skip


def _pose(track: Track, at: float) -> list[float]:
    return [float(np.interp(at, track.times, track.poses[:, k])) for k in range(3)]


def _mean_commands(track: Track, at: float) -> FloatArray:
    """Return the mean command (T, 2) of each tick."""
    edges = at + TICK * np.arange(round(SPAN / TICK) + 1)
    times, commands = np.append(track.command_times, edges[-1] + 1e3), np.vstack([track.commands, track.commands[-1:]])
    # commands are steps, their integral is a polygon; before the first a robot stands
    gone = np.vstack([np.zeros((1, 2)), np.cumsum(np.diff(times)[:, None] * commands[:-1], axis=0)])
    integral = np.column_stack([np.interp(edges, times, gone[:, k], left=0.0) for k in range(2)])
    return np.asarray(np.diff(integral, axis=0) / TICK)

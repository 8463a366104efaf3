"""What was in view of each reading: the other robots around it at any delay, by the measured poses."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.arrays import BoolArray, FloatArray, IntArray
from swarm_envs.calibration.drive.fitting import Model
from swarm_envs.calibration.drive.lost_commands import without_lost_commands
from swarm_envs.calibration.drive.motion import free_run
from swarm_envs.calibration.logs.log import Log, Track
from swarm_envs.calibration.logs.near_contact import may_touch

GRID = 0.01
"""Step in s at which paths are tabulated."""
TURNING_OVER = 0.1
"""Time in s over which a measured turn rate is taken."""
MOST = 6000
"""Readings that are looked at, about; of more, each second or third and so on: readings that follow each other tell much the same."""
LATEST = 1.5
"""Longest delay in s that is looked back."""
WIDEST_GAP = 0.3
"""Time in s between two poses beyond which it is not known where a robot was."""
REMEMBERED = 40
"""Delays whose views are kept."""


@dataclass(frozen=True)
class Views:
    """What each of D readings had around it; O other robots, missing ones infinitely far."""

    distance: FloatArray
    """(D, O) to the other robots' centres in m."""
    bearing: FloatArray
    """(D, O) of their centres from the heading in rad."""
    driving: FloatArray
    """(D,) absolute forward speed in m/s."""
    turning: FloatArray
    """(D,) absolute turn rate in rad/s."""
    detected: BoolArray
    """(D,) what was reported."""
    run: FloatArray
    """(D,) index of the run."""


@dataclass(frozen=True)
class _Path:
    """One robot of a run on a grid of :data:`GRID` s."""

    begin: float
    poses: FloatArray
    """(T, 3) x and y in m, heading in rad as measured."""
    motion: FloatArray
    """(T, 2) absolute forward speed in m/s and turn rate in rad/s, as the drive's model has them."""
    measured: BoolArray
    """(T,) whether the tracker saw the robot about then."""


class Readings:
    """The readings of a log, with views at any delay."""

    def __init__(self, log: Log, model: Model, robots: Sequence[str]) -> None:
        self.runs: list[list[tuple[Track, _Path]]] = []
        for run in log.runs:
            tracks = [track for track in log.tracks if track.run == run and len(track.times) > 1 and track.robot in robots]
            touching = may_touch(log, tracks)
            paths = [_path(track, model, robots.index(track.robot), near) for track, near in zip(tracks, touching, strict=True)]
            self.runs.append(list(zip(tracks, paths, strict=True)))
        self.stride = max(1, round(sum(len(track.detection_times) for tracks in self.runs for track, _ in tracks) / MOST))
        self.most = max([len(tracks) for tracks in self.runs], default=0)
        self.known: dict[int, Views] = {}

    def views(self, delay: float) -> Views:
        """Return what was in view ``delay`` s before each reading, to the grid's step."""
        late = round(delay / GRID)
        if late not in self.known:
            if len(self.known) > REMEMBERED:
                self.known.clear()
            self.known[late] = self._look(late * GRID)
        return self.known[late]

    def _look(self, delay: float) -> Views:
        parts = [self._look_of(number, track, path, delay) for number, tracks in enumerate(self.runs) for track, path in tracks]
        if not parts:
            return Views(np.empty((0, 1)), np.empty((0, 1)), np.empty(0), np.empty(0), np.empty(0, bool), np.empty(0))
        return Views(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in dataclasses.fields(Views)))

    def _look_of(self, run: int, track: Track, path: _Path, delay: float) -> Views:
        """Return what one robot had in view."""
        # readings whose view the tracker saw with every delay that is tried, so that all delays explain the same readings
        times = track.detection_times[:: self.stride]
        kept = (times >= path.begin + LATEST) | (times - delay >= path.begin)
        kept &= times <= path.begin + GRID * (len(path.poses) - 1)
        looked = np.maximum(times[kept] - delay, path.begin)
        index, seen = _at(path, looked)
        pose, motion = path.poses[index], path.motion[index]
        distance = np.full((len(looked), max(1, self.most - 1)), np.inf)
        bearing = np.zeros_like(distance)
        others = [other_path for other, other_path in self.runs[run] if other is not track]
        for column, other in enumerate(others):
            there, present = _at(other, looked)
            gone = other.poses[there, :2] - pose[:, :2]
            distance[:, column] = np.where(present, np.hypot(*gone.T), np.inf)
            off = np.arctan2(gone[:, 1], gone[:, 0]) - pose[:, 2]
            bearing[:, column] = (off + np.pi) % (2 * np.pi) - np.pi
        detected = track.detections[:: self.stride][kept]
        driving, turning = motion[seen].T
        return Views(distance[seen], bearing[seen], driving, turning, detected[seen], np.full(int(seen.sum()), float(run)))


def _path(track: Track, model: Model, robot: int, touching: BoolArray) -> _Path:
    """Tabulate a path.

    Poses are not smoothed: a controller turns where a reading changes, and a smoothed corner would mimic a late sensor. A corner that
    falls between two poses is where the model has it.

    Args:
        track: The track.
        model: Its drive.
        robot: Index of its robot.
        touching: (T,) whether the robot may be in contact; it then turns as measured, not as the model has it.
    """
    times = track.times
    # readings are taken at whole multiples of a hundredth of a second, if at any
    grid = np.arange(np.ceil(times[0] / GRID - 1e-6) * GRID, times[-1], GRID)
    near = np.searchsorted(times, grid)
    gap = times[np.minimum(near, len(times) - 1)] - times[np.maximum(near - 1, 0)]
    gain, told = model.gains[robot], without_lost_commands(track, model, robot)
    driven = free_run(model.parameters, dataclasses.replace(told, times=grid), gain).path
    turned = driven[:, 2]
    corners = turned - np.interp(grid, times, free_run(model.parameters, told, gain).path[:, 2])
    poses = np.column_stack([np.interp(grid, times, track.poses[:, k]) for k in range(3)])
    in_contact = np.interp(grid, times, touching.astype(float)) > 0.0
    before = np.interp(grid - TURNING_OVER, times, track.poses[:, 2])
    turning = np.where(in_contact, np.abs(poses[:, 2] - before) / TURNING_OVER, np.abs(np.diff(turned, prepend=turned[0])) / GRID)
    driving = np.hypot(*np.diff(driven[:, :2], axis=0, prepend=driven[:1, :2]).T) / GRID
    poses[:, 2] += np.where(in_contact | (gap > 2 * TURNING_OVER), 0.0, corners)
    return _Path(float(grid[0]) if len(grid) else float(times[0]), poses, np.column_stack([driving, turning]), gap < WIDEST_GAP)


def _at(path: _Path, times: FloatArray) -> tuple[IntArray, BoolArray]:
    """Return the indices (D,) in a path's tables of some times, and whether (D,) the robot was seen about then."""
    index = np.round((times - path.begin) / GRID).astype(np.int64)
    inside = (index >= 0) & (index < len(path.poses))
    index = np.clip(index, 0, len(path.poses) - 1)
    return index, inside & path.measured[index]

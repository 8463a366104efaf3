"""A log as the drive's filter takes it: poses and commands of pieces of tracks, laid end to end."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from swarm_envs.calibration.arrays import BoolArray, FloatArray, IntArray
from swarm_envs.calibration.logs.log import Log, tracked
from swarm_envs.calibration.logs.near_contact import may_touch


class MeasuredArrays(NamedTuple):
    """The part of :class:`Measured` that compiled code takes; the same names."""

    times: FloatArray
    poses: FloatArray
    first: IntArray
    command_times: FloatArray
    commands: FloatArray
    command_first: IntArray
    touching: BoolArray
    robot: IntArray


@dataclass(frozen=True)
class Measured:
    """Poses and commands of pieces of tracks, laid end to end for the compiled filter; P pieces, N poses, M commands."""

    times: FloatArray
    """(N,) s."""
    poses: FloatArray
    """(N, 3) m, m, rad."""
    first: IntArray
    """(P + 1,) index of each piece's first pose."""
    command_times: FloatArray
    """(M,) s."""
    commands: FloatArray
    """(M, 2)."""
    command_first: IntArray
    """(P + 1,) index of each piece's first command; a piece has all commands of its run."""
    touching: BoolArray
    """(N,) whether the robot may be in contact there; such poses are not predicted, the filter starts again after them."""
    robot: IntArray
    """(P,) index of the robot."""
    run: IntArray
    """(P,) index of the group that is held out together: the run, or the piece where runs are few."""
    robots: tuple[str, ...]
    """Names of the robots."""
    runs: tuple[str, ...]
    """Names of the groups."""

    @property
    def arrays(self) -> MeasuredArrays:
        """What compiled code takes of it."""
        return MeasuredArrays(*(getattr(self, name) for name in MeasuredArrays._fields))

    def of_runs(self, runs: Sequence[int]) -> Measured:
        """Return the pieces of some groups only."""
        return self.of_pieces([piece for piece in range(len(self.robot)) if self.run[piece] in set(runs)])

    def thinned(self) -> Measured:
        """Return every second pose only."""
        kept = np.zeros(len(self.times), bool)
        for piece in range(len(self.robot)):
            kept[self.first[piece] : self.first[piece + 1] : 2] = True
        first = np.concatenate([[0], np.cumsum(kept)])[self.first]
        return dataclasses.replace(self, times=self.times[kept], poses=self.poses[kept], touching=self.touching[kept], first=first)

    def of_pieces(self, pieces: Sequence[int]) -> Measured:
        """Return some pieces only."""
        poses = [slice(self.first[p], self.first[p + 1]) for p in pieces]
        commands = [slice(self.command_first[p], self.command_first[p + 1]) for p in pieces]
        return Measured(
            times=np.concatenate([self.times[s] for s in poses]), poses=np.concatenate([self.poses[s] for s in poses]),
            first=np.cumsum([0, *(s.stop - s.start for s in poses)]),
            touching=np.concatenate([self.touching[s] for s in poses]),
            command_times=np.concatenate([self.command_times[s] for s in commands]),
            commands=np.concatenate([self.commands[s] for s in commands]),
            command_first=np.cumsum([0, *(s.stop - s.start for s in commands)]),
            robot=self.robot[list(pieces)], run=self.run[list(pieces)], robots=self.robots, runs=self.runs,
        )  # fmt: skip


def measured(log: Log, most: int = 8000, piece: float = 20.0) -> Measured:
    """Lay a log's tracks end to end, thinned to about ``most`` poses.

    With fewer than five runs each run is cut into pieces of ``piece`` s, which are then what is held out.
    """
    tracks = tracked(log)
    touching = may_touch(log, tracks)
    runs = tuple(dict.fromkeys(track.run for track in tracks))
    robots = tuple(dict.fromkeys(track.robot for track in tracks))
    spacing = sum(track.duration for track in tracks) / most
    cut = len(runs) < 5
    times, poses, touch, commands, command_times, robot, run, names = [], [], [], [], [], [], [], []
    for track, touches in zip(tracks, touching, strict=True):
        kept = _thinned(track.times, spacing)
        count = max(1, round(track.duration / piece)) if cut else 1
        for number, part in enumerate(np.array_split(kept, count)):
            name = f"{track.run}, part {number + 1}" if cut else track.run
            if name not in names:
                names.append(name)
            times.append(track.times[part])
            poses.append(track.poses[part])
            touch.append(touches[part])
            command_times.append(track.command_times)
            commands.append(track.commands)
            robot.append(robots.index(track.robot))
            run.append(names.index(name))
    return Measured(
        times=np.concatenate(times), poses=np.concatenate(poses), first=np.cumsum([0, *map(len, times)]),
        touching=np.concatenate(touch),
        command_times=np.concatenate(command_times), commands=np.concatenate(commands),
        command_first=np.cumsum([0, *map(len, commands)]), robot=np.array(robot), run=np.array(run), robots=robots, runs=tuple(names),
    )  # fmt: skip


def _thinned(times: FloatArray, spacing: float) -> IntArray:
    """Indices of poses at least about ``spacing`` s apart."""
    bins = np.floor((times - times[0]) / max(spacing, 1e-6) + 1e-6)
    return np.flatnonzero(np.append(True, np.diff(bins) > 0))


def run_of(group: str) -> str:
    """Return the run that a group of :func:`swarm_envs.calibration.drive.measured.measured` is, or is a part of."""
    return group.rpartition(", part ")[0] or group

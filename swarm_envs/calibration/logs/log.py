"""A measured log: what was commanded, where the robots went, what they reported to see.

A log is a folder with ``log.yaml`` (robot, units, source, optionally the arena's ``outline`` in the log's own frame) and the tables
``poses`` (run, robot, t, x, y, theta), ``commands`` (run, robot, t, v, omega; in force from t until the next row) and, if any,
``detections`` (run, robot, t, detected), as CSV or Parquet; ROS bags are logs too, see :mod:`swarm_envs.calibration.logs.bags`. Times
are seconds from the start of a run, one clock.
"""

from __future__ import annotations

from dataclasses import dataclass

from swarm_envs.calibration.arrays import BoolArray, FloatArray
from swarm_envs.calibration.errors import LogError


@dataclass(frozen=True)
class Track:
    """One robot in one run, in SI units, each table sorted by time without duplicates."""

    run: str
    """Name of the run."""
    robot: str
    """Name of the robot."""
    times: FloatArray
    """(T,) of the poses, s from the start of the run."""
    poses: FloatArray
    """(T, 3) x and y in m, heading in rad, unwrapped."""
    command_times: FloatArray
    """(M,) s."""
    commands: FloatArray
    """(M, 2) v and omega, in force until the next; in m/s and rad/s, or the driver's units."""
    detection_times: FloatArray
    """(D,) s."""
    detections: BoolArray
    """(D,) whether the robot's sensor reported another."""

    @property
    def duration(self) -> float:
        """Time from the first to the last pose in s."""
        return float(self.times[-1] - self.times[0]) if len(self.times) else 0.0


@dataclass(frozen=True)
class Log:
    """A measured log."""

    name: str
    """Name that the log gives itself, else its folder's."""
    tracks: tuple[Track, ...]
    """Every robot of every run, in the order of their first appearance."""
    outline: tuple[tuple[float, float], ...] | None = None
    """Corners of the arena in the log's own frame in m, if the log gives them."""
    driver_units: bool = False
    """Whether the log does not say that its commands are in SI units."""
    notes: tuple[str, ...] = ()
    """What was repaired on reading, a sentence each."""

    @property
    def runs(self) -> tuple[str, ...]:
        """Names of the runs, in order."""
        return tuple(dict.fromkeys(track.run for track in self.tracks))

    @property
    def robots(self) -> tuple[str, ...]:
        """Names of the robots, in order."""
        return tuple(dict.fromkeys(track.robot for track in self.tracks))

    @property
    def tracked(self) -> tuple[Track, ...]:
        """Tracks with poses and commands enough to predict anything."""
        return tuple(track for track in self.tracks if len(track.times) > 10 and len(track.command_times))


def tracked(log: Log) -> tuple[Track, ...]:
    """Return the tracks that can be predicted.

    Raises:
        LogError: When there is none.
    """
    if not log.tracked:
        raise LogError(f"{log.name}: no robot has both poses and commands; nothing to predict")
    return log.tracked

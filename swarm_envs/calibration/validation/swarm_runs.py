"""Runs in which a whole swarm was tracked, and the controller that its robots obeyed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.drive.fitting import Model
from swarm_envs.calibration.drive.measured import Measured, run_of
from swarm_envs.calibration.logs.log import Log, Track
from swarm_envs.calibration.prediction.arena import TICK, at

FEWEST = 3
"""Robots that make a swarm."""
EVERY = 2
"""Ticks of a replay from one frame to the next: 0.1 s."""
OBEYED = 0.9
"""Share of commands that must follow the detections before a log's controllers are believed."""


@dataclass(frozen=True)
class SwarmRun:
    """A run in which all robots of a swarm were tracked."""

    tracks: tuple[Track, ...]
    begin: float
    """s"""
    frames: FloatArray
    """(F, R, 3) measured poses, 0.1 s apart."""
    model: Model
    """The drive, fitted without this run."""
    gains: dict[str, FloatArray]
    """By robot, its own factors on both gains."""
    controller: FloatArray | None
    """(4,) [v0, omega0, v1, omega1], where commands follow detections."""

    @property
    def time(self) -> FloatArray:
        """(F,) s from the first frame."""
        return np.asarray(EVERY * TICK * np.arange(len(self.frames)), np.float64)


def swarm_runs(log: Log, data: Measured, after: Sequence[Model]) -> list[SwarmRun]:
    """Return the runs with at least :data:`FEWEST` robots, all tracked, for at least 2 s together."""
    predicted = {(track.run, track.robot) for track in log.tracked}
    models = {run_of(name): model for name, model in zip(data.runs, after, strict=True)}
    found = []
    for run in log.runs:
        tracks = tuple(track for track in log.tracks if track.run == run)
        if len(tracks) < FEWEST or any((run, track.robot) not in predicted for track in tracks):
            continue
        begin, end = max(track.times[0] for track in tracks), min(track.times[-1] for track in tracks)
        if end - begin < 2.0:
            continue
        times = begin + EVERY * TICK * np.arange(int((end - begin) / (EVERY * TICK) + 1e-9) + 1)
        gains = dict(zip(data.robots, models[run].gains, strict=True))
        frames = np.stack([at(track, times) for track in tracks], axis=1)
        found.append(SwarmRun(tracks, float(begin), frames, models[run], gains, controller_of(tracks)))
    return found


def controller_of(tracks: Sequence[Track]) -> FloatArray | None:
    """Return the controller [v0, omega0, v1, omega1] that all robots of a run obeyed, if they did.

    Commands other than the two most frequent ones are allowed as long as :data:`OBEYED` of all follow the detections.
    """
    given, seen = [], []
    for track in tracks:
        if not len(track.detection_times):
            return None
        # a controller answers a reading at once or a little later
        latest = np.searchsorted(track.detection_times, track.command_times + 1e-6, side="right") - 1
        given.append(track.commands[latest >= 0])
        seen.append(track.detections[latest[latest >= 0]])
    commands, detected = np.concatenate(given), np.concatenate(seen)
    pairs = []
    for reading in (False, True):
        answers, counts = np.unique(np.round(commands[detected == reading], 6), axis=0, return_counts=True)
        if not len(answers):
            return None
        pairs.append(answers[np.argmax(counts)])
    obeyed = np.abs(commands - np.where(detected[:, None], pairs[1], pairs[0])).max(axis=1) < 1e-5
    return np.concatenate(pairs) if obeyed.mean() >= OBEYED else None

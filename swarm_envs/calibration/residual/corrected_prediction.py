"""Free-running prediction with corrections along the predicted path, and its errors on held-out runs."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.arrays import FloatArray, IntArray
from swarm_envs.calibration.drive.fitting import BLOCK, Model
from swarm_envs.calibration.drive.motion import free_run
from swarm_envs.calibration.drive.parameters import INDEX
from swarm_envs.calibration.logs.log import Log, Track, tracked
from swarm_envs.calibration.prediction.windows import HORIZONS, rms, windows
from swarm_envs.calibration.residual.corrections import Covariates, Term, corrections
from swarm_envs.calibration.residual.residuals import group_of, held_out_together, situation

STEP = 0.05
"""Step in s with which corrected motion is integrated."""


@dataclass(frozen=True)
class Errors:
    """Errors at the ends of all windows of one length, on held-out runs."""

    horizon_s: float
    place: FloatArray
    """(W,) m."""
    heading: FloatArray
    """(W,) rad."""
    block: IntArray
    """(W,) windows of one block may err alike; blocks err independently."""

    @property
    def sizes(self) -> tuple[float, float]:
        """Both rms, in m and rad."""
        return rms(self.place), rms(self.heading)


def heldout_errors(log: Log, models: Sequence[Model], robots: tuple[str, ...], terms: Sequence[Term] = ()) -> tuple[Errors, ...]:
    """Return free-running errors per horizon, with corrections that were fitted to other runs.

    Each window starts from a measured pose and sees nothing but the commands; corrections are taken along the predicted path.

    Args:
        log: The log.
        models: The drive for each group that is held out together.
        robots: Names of the robots in the order of the models' gains.
        terms: The corrections.
    """
    groups = held_out_together(log)
    rows = []
    for horizon in HORIZONS:
        errors: list[FloatArray] = []
        blocks: list[FloatArray] = []
        for number, track in enumerate(tracked(log)):
            first, last = windows(track.times, horizon)
            if not len(first):
                continue
            group = np.array([group_of(groups, track, float(t)) for t in track.times[first]], np.int64)
            missed = np.empty((len(first), 2))
            for held in np.unique(group):
                of = group == held
                model = models[held]
                path = predict(model, track, robots.index(track.robot), first[of], last[of], terms, group[of])
                missed[of] = _missed(path, track.poses[last[of]])
            errors.append(missed)
            blocks.append(np.column_stack([np.full(len(first), number), np.floor(track.times[first] / BLOCK)]))
        if errors:
            place, heading = np.concatenate(errors).T
            rows.append(Errors(horizon, place, heading, np.unique(np.concatenate(blocks), axis=0, return_inverse=True)[1].ravel()))
    return tuple(rows)


def _missed(predicted: FloatArray, measured: FloatArray) -> FloatArray:
    turned = (predicted[:, 2] - measured[:, 2] + np.pi) % (2 * np.pi) - np.pi
    return np.column_stack([np.hypot(*(predicted[:, :2] - measured[:, :2]).T), turned])


def predict(
    model: Model, track: Track, robot: int, first: IntArray, last: IntArray, terms: Sequence[Term], group: IntArray | None = None
) -> FloatArray:
    """Return the measured poses (W, 3) predicted at the ends of windows, corrections included.

    Args:
        model: The drive.
        track: The track.
        robot: Index of its robot.
        first: (W,) indices of the poses that windows start from.
        last: (W,) indices of those that they end at.
        terms: The corrections.
        group: (W,) the held-out group of each window, for corrections fitted without it; None for those fitted to all.
    """
    gain, yaw = model.gains[robot], float(model.parameters[INDEX["marker_yaw"]])
    begin, end = track.times[first], track.times[last]
    fine = np.arange(begin.min(), end.max() + 0.02, 0.02)
    run = free_run(model.parameters, dataclasses.replace(track, times=fine), gain)
    steps = max(1, int(np.ceil(float((end - begin).max()) / STEP)))
    pose = track.poses[first] - np.array([0.0, 0.0, yaw])
    dt = (end - begin) / steps
    now = _at(begin, fine, run.path, run.drift)
    for step in range(steps):
        then = _at(begin + (step + 1) * dt, fine, run.path, run.drift)
        turned = then[:, 2] - now[:, 2]
        middle = 0.5 * (then[:, 2] + now[:, 2])
        gone = then[:, :2] - now[:, :2]
        body = np.column_stack([
            np.cos(middle) * gone[:, 0] + np.sin(middle) * gone[:, 1], np.cos(middle) * gone[:, 1] - np.sin(middle) * gone[:, 0], turned,
        ])  # fmt: skip
        if terms:
            time = begin + (step + 0.5) * dt
            command, since = situation(track, time)
            ahead = pose + np.column_stack([np.zeros((len(pose), 2)), 0.5 * turned])
            ahead[:, :2] += 0.5 * _turned(body[:, :2], ahead[:, 2])
            at = Covariates(ahead, body[:, ::2] / dt[:, None], command, since, time, np.full(len(pose), float(robot)))
            body = body + corrections(terms, at, group) * dt[:, None]
        pose[:, :2] += _turned(body[:, :2], pose[:, 2] + 0.5 * body[:, 2]) + then[:, 3:] - now[:, 3:]
        pose[:, 2] += body[:, 2]
        now = then
    pose[:, 2] += yaw
    return np.asarray(pose)


def _at(times: FloatArray, fine: FloatArray, path: FloatArray, drift: FloatArray) -> FloatArray:
    return np.column_stack([np.interp(times, fine, column) for column in (*path.T, *drift.T)])


def _turned(moved: FloatArray, heading: FloatArray) -> FloatArray:
    c, s = np.cos(heading), np.sin(heading)
    return np.column_stack([c * moved[:, 0] - s * moved[:, 1], s * moved[:, 0] + c * moved[:, 1]])

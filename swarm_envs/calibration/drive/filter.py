"""Likelihood of measured poses under a drive: an extended Kalman filter over (x, y, heading).

The drive moves the state, process noise widens it while the robot is on the move, the tracker measures it. Without process noise this
is free-running prediction with the best start pose; with it, each prediction starts from what has been measured so far. One
likelihood therefore serves both a log whose only noise is the tracker's and a real robot's.

Chance is part of the model: a start's random turn widens the heading; where commands may be lost, a beam of hypotheses of which
command is in force is carried along.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.drive.hypotheses import LONG_AGO, Hypotheses, begin_at_rest, branch, empty_hypotheses, restart
from swarm_envs.calibration.drive.kalman import correct, predict
from swarm_envs.calibration.drive.measured import Measured, MeasuredArrays
from swarm_envs.calibration.drive.motion import LONGEST_STEP, goal_at
from swarm_envs.calibration.drive.noise import HEADING, PLACE
from swarm_envs.calibration.drive.parameters import DriveParameters, as_drives
from swarm_envs.compiled import compiled
from swarm_envs.simulation.drive_law import asks_to_move, start_kick, time_of_effect

LONGEST_ARC = 0.25
"""Time in s over which the noise of a motion without lag is taken to have one direction."""
KICKING = 0.002
"""Time in s that a start's turn may take: a pose measured meanwhile shows part of it."""


class Filtered(NamedTuple):
    """What the filter makes of N poses; a piece's first pose and those in contact have no prediction, and zeros."""

    log_likelihood: FloatArray
    """(N,) of each pose given those before it."""
    innovation: FloatArray
    """(N, 3) measured minus predicted pose."""
    covariance: FloatArray
    """(N, 3, 3) of the innovation as the model expects it."""

    @property
    def total(self) -> float:
        """Log-likelihood of all poses."""
        return float(self.log_likelihood.sum())


def filter_log(parameters: FloatArray, noise: FloatArray, gains: FloatArray, data: Measured) -> Filtered:
    """Run the filter over a log.

    Args:
        parameters: (P,) of the drive, see :mod:`swarm_envs.calibration.drive.parameters`.
        noise: (5,) standard deviations, see :data:`swarm_envs.calibration.drive.noise.NOISE`.
        gains: (R, 2) each robot's own factors on both gains.
        data: The log.
    """
    count = len(data.times)
    out = Filtered(np.zeros(count), np.zeros((count, 3)), np.tile(np.eye(3), (count, 1, 1)))
    filter_pieces(as_drives(parameters), noise, gains, data.arrays, empty_hypotheses(), out)
    return out


@compiled(_nrt=False)
def filter_pieces(
    drives: Sequence[DriveParameters], noise: FloatArray, gains: FloatArray, data: MeasuredArrays, beam: Hypotheses, out: Filtered
) -> None:
    """Run the filter over every piece of a log; see :func:`filter_log`. ``beam`` is working space, ``out`` is written."""
    for piece in range(data.robot.shape[0]):
        filter_piece(drives[0], noise, gains[data.robot[piece]], data, piece, beam, out)


@compiled(forceinline=True, _nrt=False)
def filter_piece(
    drive: DriveParameters, noise: FloatArray, factors: FloatArray, data: MeasuredArrays, piece: int, beam: Hypotheses, out: Filtered
) -> None:
    """Run the filter over one piece."""
    place_variance, heading_variance = noise[PLACE] ** 2, noise[HEADING] ** 2
    # without lag a command's motion is an arc however long it lasts
    longest = LONGEST_STEP if drive.effects.motor_lag > 0.0 else LONGEST_ARC
    begin_at_rest(beam)
    count = 1
    next_command = next_asked = data.command_first[piece]
    last_command = data.command_first[piece + 1]
    asked = kicked = LONG_AGO
    asking = False
    first = data.first[piece]
    now = data.times[first]
    if next_command < last_command:
        now = min(now, time_of_effect(drive.effects, data.command_times[next_command]))
    for n in range(first, data.first[piece + 1]):
        while now < data.times[n]:
            while next_command < last_command and time_of_effect(drive.effects, data.command_times[next_command]) <= now + 1e-12:
                v, omega = data.commands[next_command, 0], data.commands[next_command, 1]
                next_command += 1
                count = branch(beam, count, drive.effects.command_loss, v, omega)
                if start(drive, factors, beam, count, now):
                    kicked = now
            until = min(data.times[n], now + longest)
            if next_command < last_command:
                until = min(until, time_of_effect(drive.effects, data.command_times[next_command]))
            # a robot may move from when it is asked to, whatever dead time the model has
            while next_asked < last_command and data.command_times[next_asked] <= now + 1e-12:
                asking = asks_to_move(data.commands[next_asked, 0], data.commands[next_asked, 1])
                next_asked += 1
            if next_asked < last_command:
                until = min(until, max(now, data.command_times[next_asked]))
            if asking:
                asked = now
            for h in range(count):
                beam.moved[h] = max(beam.moved[h], asked)
                predict(drive, noise, factors, beam, h, now, until - now)
            now = until
        x, y, heading = data.poses[n, 0], data.poses[n, 1], data.poses[n, 2]
        if n == first or data.touching[n]:
            count = restart(beam, count, x, y, heading, place_variance, heading_variance)
            continue
        for h in range(count):
            beam.score[h] = beam.weight[h] + correct(beam, h, x, y, heading, place_variance, heading_variance)
        weigh(beam, count, out, n)
        if data.times[n] - kicked < KICKING:
            for h in range(count):
                beam.covariance[h, 2, 2] += drive.effects.start_kick_sd**2


@compiled(forceinline=True, _nrt=False)
def start(drive: DriveParameters, factors: FloatArray, beam: Hypotheses, count: int, now: float) -> bool:
    """Turn the hypotheses in which a robot starts from rest at a time in s; whether there are any."""
    any_starts = False
    for h in range(count):
        goal_v, goal_omega = goal_at(drive, factors, beam.latched[h, 0], beam.latched[h, 1], now)
        moves = asks_to_move(goal_v, goal_omega)
        if moves and not beam.moving[h]:
            beam.pose[h, 2] += start_kick(drive.effects, 0.0)
            beam.covariance[h, 2, 2] += drive.effects.start_kick_sd**2
            any_starts = True
        beam.moving[h] = moves
    return any_starts


@compiled(forceinline=True, _nrt=False)
def weigh(beam: Hypotheses, count: int, out: Filtered, n: int) -> None:
    """Give the hypotheses the weights of their scores at pose ``n``, and write what the likeliest makes of it."""
    best = 0
    for h in range(count):
        if beam.score[h] > beam.score[best]:
            best = h
    total = 0.0
    for h in range(count):
        total += math.exp(beam.score[h] - beam.score[best])
    total = beam.score[best] + math.log(total)
    out.log_likelihood[n] = total
    for i in range(3):
        out.innovation[n, i] = beam.innovation[best, i]
        for j in range(3):
            out.covariance[n, i, j] = beam.innovation_covariance[best, i, j]
    for h in range(count):
        beam.weight[h] = beam.score[h] - total

"""Likelihood of measured poses under a drive: an extended Kalman filter over (x, y, heading).

The drive moves the state, process noise blurs it while the robot is on the move, the tracker measures it. Without process noise this
is free-running prediction with the best start pose; with it, each prediction starts from what has been measured so far. One
likelihood therefore serves both a log whose only noise is the tracker's and a real robot's.

Chance is part of the model: a start's random turn widens the heading; where commands may be lost, a beam of hypotheses of which
command is in force is carried along.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.arrays import BoolArray, FloatArray, IntArray
from swarm_envs.calibration.drive.measured import Measured
from swarm_envs.calibration.drive.motion import (
    COMMAND_LOSS,
    DEAD_TIME,
    FLOOR_X,
    FLOOR_Y,
    KICK_MEAN,
    KICK_SD,
    LONGEST_STEP,
    MARKER_YAW,
    MOTOR_LAG,
    TURN_BIAS,
    lag,
    sinc,
    target,
)
from swarm_envs.compiled import compiled

LONGEST_ARC = 0.25
"""Time in s over which the noise of a motion without lag is taken to have one direction."""
BEAM = 5
"""Hypotheses of the command in force that are carried along."""
COMING_TO_REST = 1.0
"""Time in s after the last motion asked for in which a robot still counts as moving."""
NOISE = ("place", "heading", "along", "across", "turn")
"""Names of the noise: the tracker's in m and rad, the motion's along and across the heading in m/sqrt(s), in rad/sqrt(s)."""
PLACE, HEADING, ALONG, ACROSS, TURN = range(5)
KICKING = 0.002
"""Time in s that a start's turn may take: a pose measured meanwhile shows part of it."""
RESTING = 0.1
"""Process noise of a robot at rest, as a share of that on the move."""


@dataclass(frozen=True)
class Filtered:
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
        parameters: (16,) of the drive.
        noise: (5,) standard deviations, see :data:`NOISE`.
        gains: (R, 2) each robot's own factors on both gains.
        data: The log.
    """
    count = len(data.times)
    out = Filtered(np.zeros(count), np.zeros((count, 3)), np.tile(np.eye(3), (count, 1, 1)))
    most = 2 * BEAM
    _filter(
        parameters, noise, gains, data.times, data.poses, data.touching, data.first, data.command_times, data.commands, data.command_first,
        data.robot, np.zeros((most, 3)), np.zeros((most, 3, 3)), np.zeros((most, 2)), np.zeros((most, 2)), np.zeros(most, np.bool_),
        np.zeros((5, most)), np.zeros((most, 3)), np.zeros((most, 3, 3)), out.log_likelihood, out.innovation, out.covariance,
    )  # fmt: skip
    return out


@compiled(_nrt=False)
def _filter(
    p: FloatArray, noise: FloatArray, gains: FloatArray, times: FloatArray, poses: FloatArray, touching: BoolArray, first: IntArray,
    command_times: FloatArray, commands: FloatArray, command_first: IntArray, robot: IntArray,
    state: FloatArray, spread: FloatArray, motor: FloatArray, held: FloatArray, moving: BoolArray, work: FloatArray, nu: FloatArray,
    expected: FloatArray, likelihood: FloatArray, innovation: FloatArray, covariance: FloatArray,
) -> None:  # fmt: skip
    """Write the log-likelihood (N,), innovation (N, 3) and its covariance (N, 3, 3) of every pose; the others are working space."""
    most = BEAM if p[COMMAND_LOSS] > 0.0 else 1
    moved, weight, scores = work[0], work[1], work[2]
    r_place, r_heading = noise[PLACE] ** 2, noise[HEADING] ** 2
    # without lag a command's motion is an arc however long it lasts
    longest = LONGEST_STEP if p[MOTOR_LAG] > 1e-9 else LONGEST_ARC
    for piece in range(robot.shape[0]):
        gain = gains[robot[piece]]
        beams = 1
        motor[0, 0] = motor[0, 1] = 0.0
        held[0, 0] = held[0, 1] = 0.0
        moving[0] = False
        moved[0] = -1e9
        weight[0] = 0.0
        started = False
        next_command = command_first[piece]
        last_command = command_first[piece + 1]
        next_given = next_command
        asked = kicked = -1e9
        asking = False
        now = times[first[piece]]
        if next_command < last_command:
            now = min(now, command_times[next_command] + p[DEAD_TIME])
        for n in range(first[piece], first[piece + 1]):
            while now < times[n]:
                while next_command < last_command and command_times[next_command] + p[DEAD_TIME] <= now + 1e-12:
                    v, omega = commands[next_command, 0], commands[next_command, 1]
                    next_command += 1
                    if p[COMMAND_LOSS] > 0.0:
                        beams = _branch(p[COMMAND_LOSS], v, omega, beams, most, state, spread, motor, held, moving, moved, weight)
                    else:
                        held[0, 0], held[0, 1] = v, omega
                    for h in range(beams):
                        goal_v, goal_omega = target(p, gain, held[h, 0], held[h, 1], now)
                        moves = goal_v != 0.0 or goal_omega != 0.0
                        if moves and not moving[h]:
                            state[h, 2] += p[KICK_MEAN]
                            spread[h, 2, 2] += p[KICK_SD] ** 2
                            kicked = now
                        moving[h] = moves
                until = min(times[n], now + longest)
                if next_command < last_command:
                    until = min(until, command_times[next_command] + p[DEAD_TIME])
                # a robot may move from when it is asked to, whatever dead time the model has
                while next_given < last_command and command_times[next_given] <= now + 1e-12:
                    asking = commands[next_given, 0] != 0.0 or commands[next_given, 1] != 0.0
                    next_given += 1
                if next_given < last_command:
                    until = min(until, max(now, command_times[next_given]))
                dt = until - now
                if asking:
                    asked = now
                for h in range(beams):
                    moved[h] = max(moved[h], asked)
                    _advance(p, noise, gain, held, motor, moving[h], moved, h, now, dt, state, spread)
                now = until
            if not started or touching[n]:
                started = True
                for h in range(beams):
                    for i in range(3):
                        state[h, i] = poses[n, i]
                        for j in range(3):
                            spread[h, i, j] = 0.0
                    spread[h, 0, 0] = spread[h, 1, 1] = r_place
                    spread[h, 2, 2] = r_heading
                beams = _merge(beams, state, spread, motor, held, moving, moved, weight)
                continue
            best = 0
            for h in range(beams):
                scores[h] = weight[h] + _update(poses, n, r_place, r_heading, state, spread, h, nu, expected)
                if scores[h] > scores[best]:
                    best = h
            total = 0.0
            for h in range(beams):
                total += math.exp(scores[h] - scores[best])
            total = scores[best] + math.log(total)
            likelihood[n] = total
            for i in range(3):
                innovation[n, i] = nu[best, i]
                for j in range(3):
                    covariance[n, i, j] = expected[best, i, j]
            for h in range(beams):
                weight[h] = scores[h] - total
                if times[n] - kicked < KICKING:
                    spread[h, 2, 2] += p[KICK_SD] ** 2


@compiled(_nrt=False)
def _advance(
    p: FloatArray, noise: FloatArray, gain: FloatArray, held: FloatArray, motor: FloatArray, moving: bool, moved: FloatArray, h: int,
    now: float, dt: float, state: FloatArray, spread: FloatArray,
) -> None:  # fmt: skip
    """Move hypothesis ``h`` by ``dt`` s."""
    goal_v, goal_omega = target(p, gain, held[h, 0], held[h, 1], now + 0.5 * dt)
    v, motor[h, 0] = lag(motor[h, 0], goal_v, dt, p[MOTOR_LAG])
    omega, motor[h, 1] = lag(motor[h, 1], goal_omega, dt, p[MOTOR_LAG])
    if moving or abs(motor[h, 0]) > 1e-3 or abs(motor[h, 1]) > 1e-2:
        moved[h] = now
    share = dt if now - moved[h] < COMING_TO_REST else dt * RESTING * RESTING
    along, across = share * noise[ALONG] ** 2, share * noise[ACROSS] ** 2
    half = 0.5 * (omega + p[TURN_BIAS] * v) * dt
    chord = v * sinc(half) * dt
    direction = state[h, 2] - p[MARKER_YAW] + half
    c, s = math.cos(direction), math.sin(direction)
    fx, fy = -chord * s, chord * c
    state[h, 0] += fy
    state[h, 1] -= fx
    state[h, 2] += 2.0 * half
    if moving:
        state[h, 0] += p[FLOOR_X] * dt
        state[h, 1] += p[FLOOR_Y] * dt
    # P = F P F' with F = [[1, 0, fx], [0, 1, fy], [0, 0, 1]]
    p02, p12, p22 = spread[h, 0, 2], spread[h, 1, 2], spread[h, 2, 2]
    spread[h, 0, 0] += 2.0 * fx * p02 + fx * fx * p22 + along * c * c + across * s * s
    spread[h, 1, 1] += 2.0 * fy * p12 + fy * fy * p22 + along * s * s + across * c * c
    spread[h, 0, 1] += fx * p12 + fy * p02 + fx * fy * p22 + (along - across) * c * s
    spread[h, 0, 2] += fx * p22
    spread[h, 1, 2] += fy * p22
    spread[h, 2, 2] += share * noise[TURN] ** 2
    spread[h, 1, 0] = spread[h, 0, 1]
    spread[h, 2, 0] = spread[h, 0, 2]
    spread[h, 2, 1] = spread[h, 1, 2]


@compiled(_nrt=False)
def _update(
    poses: FloatArray, n: int, r_place: float, r_heading: float, state: FloatArray, spread: FloatArray, h: int, nu: FloatArray,
    expected: FloatArray,
) -> float:  # fmt: skip
    """Take in a measured pose; returns its log-likelihood, writes innovation (3,) and its covariance (3, 3) of hypothesis ``h``."""
    p00, p01, p02 = spread[h, 0, 0], spread[h, 0, 1], spread[h, 0, 2]
    p11, p12, p22 = spread[h, 1, 1], spread[h, 1, 2], spread[h, 2, 2]
    a, d, f = p00 + r_place, p11 + r_place, p22 + r_heading
    nu0, nu1, nu2 = poses[n, 0] - state[h, 0], poses[n, 1] - state[h, 1], poses[n, 2] - state[h, 2]
    nu[h, 0], nu[h, 1], nu[h, 2] = nu0, nu1, nu2
    expected[h, 0, 0], expected[h, 1, 1], expected[h, 2, 2] = a, d, f
    expected[h, 0, 1] = expected[h, 1, 0] = p01
    expected[h, 0, 2] = expected[h, 2, 0] = p02
    expected[h, 1, 2] = expected[h, 2, 1] = p12
    i00, i01, i02 = d * f - p12 * p12, p02 * p12 - p01 * f, p01 * p12 - p02 * d
    determinant = a * i00 + p01 * i01 + p02 * i02
    i00, i01, i02 = i00 / determinant, i01 / determinant, i02 / determinant
    i11, i12, i22 = (a * f - p02 * p02) / determinant, (p01 * p02 - a * p12) / determinant, (a * d - p01 * p01) / determinant
    w0, w1, w2 = i00 * nu0 + i01 * nu1 + i02 * nu2, i01 * nu0 + i11 * nu1 + i12 * nu2, i02 * nu0 + i12 * nu1 + i22 * nu2
    state[h, 0] += p00 * w0 + p01 * w1 + p02 * w2
    state[h, 1] += p01 * w0 + p11 * w1 + p12 * w2
    state[h, 2] += p02 * w0 + p12 * w1 + p22 * w2
    # P - P S^-1 P
    g00, g01, g02 = p00 * i00 + p01 * i01 + p02 * i02, p00 * i01 + p01 * i11 + p02 * i12, p00 * i02 + p01 * i12 + p02 * i22
    g10, g11, g12 = p01 * i00 + p11 * i01 + p12 * i02, p01 * i01 + p11 * i11 + p12 * i12, p01 * i02 + p11 * i12 + p12 * i22
    g20, g21, g22 = p02 * i00 + p12 * i01 + p22 * i02, p02 * i01 + p12 * i11 + p22 * i12, p02 * i02 + p12 * i12 + p22 * i22
    spread[h, 0, 0] = p00 - (g00 * p00 + g01 * p01 + g02 * p02)
    spread[h, 1, 1] = p11 - (g10 * p01 + g11 * p11 + g12 * p12)
    spread[h, 2, 2] = p22 - (g20 * p02 + g21 * p12 + g22 * p22)
    spread[h, 0, 1] = spread[h, 1, 0] = p01 - (g00 * p01 + g01 * p11 + g02 * p12)
    spread[h, 0, 2] = spread[h, 2, 0] = p02 - (g00 * p02 + g01 * p12 + g02 * p22)
    spread[h, 1, 2] = spread[h, 2, 1] = p12 - (g10 * p02 + g11 * p12 + g12 * p22)
    squared = nu0 * w0 + nu1 * w1 + nu2 * w2
    return float(-0.5 * (squared + math.log(max(determinant, 1e-300)) + 3.0 * math.log(2.0 * math.pi)))


@compiled(_nrt=False)
def _invert(m: FloatArray, inverse: FloatArray) -> float:
    """Write the inverse of a symmetric 3 x 3 matrix; returns the determinant."""
    a, b, c, d, e, f = m[0, 0], m[0, 1], m[0, 2], m[1, 1], m[1, 2], m[2, 2]
    i00, i01, i02 = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * i00 + b * i01 + c * i02
    inverse[0, 0] = i00 / determinant
    inverse[0, 1] = inverse[1, 0] = i01 / determinant
    inverse[0, 2] = inverse[2, 0] = i02 / determinant
    inverse[1, 1] = (a * f - c * c) / determinant
    inverse[1, 2] = inverse[2, 1] = (b * c - a * e) / determinant
    inverse[2, 2] = (a * d - b * b) / determinant
    return float(max(determinant, 1e-300))


@compiled(_nrt=False)
def _copy(
    source: int, goal: int, state: FloatArray, spread: FloatArray, motor: FloatArray, held: FloatArray, moving: BoolArray,
    moved: FloatArray, weight: FloatArray,
) -> None:  # fmt: skip
    """Write one hypothesis over another."""
    for i in range(3):
        state[goal, i] = state[source, i]
        for j in range(3):
            spread[goal, i, j] = spread[source, i, j]
    for i in range(2):
        motor[goal, i], held[goal, i] = motor[source, i], held[source, i]
    moving[goal], moved[goal], weight[goal] = moving[source], moved[source], weight[source]


@compiled(_nrt=False)
def _merge(
    beams: int, state: FloatArray, spread: FloatArray, motor: FloatArray, held: FloatArray, moving: BoolArray, moved: FloatArray,
    weight: FloatArray,
) -> int:  # fmt: skip
    """Make one of hypotheses that start anew at a measured pose and move alike from there; returns how many are left.

    Left apart, the many ways to one command would crowd out the less likely commands, of which one may be in force.
    """
    kept = 0
    for h in range(beams):
        same = -1
        for k in range(kept):
            alike = held[k, 0] == held[h, 0] and held[k, 1] == held[h, 1] and moving[k] == moving[h]
            if alike and abs(motor[k, 0] - motor[h, 0]) < 1e-3 and abs(motor[k, 1] - motor[h, 1]) < 1e-2:
                same = k
                break
        if same >= 0:
            high, low = max(weight[same], weight[h]), min(weight[same], weight[h])
            weight[same] = high + math.log1p(math.exp(low - high))
            moved[same] = max(moved[same], moved[h])
        else:
            if kept != h:
                _copy(h, kept, state, spread, motor, held, moving, moved, weight)
            kept += 1
    return kept


@compiled(_nrt=False)
def _branch(
    lost: float, v: float, omega: float, beams: int, most: int, state: FloatArray, spread: FloatArray, motor: FloatArray,
    held: FloatArray, moving: BoolArray, moved: FloatArray, weight: FloatArray,
) -> int:  # fmt: skip
    """Let a command arrive or be lost in every hypothesis; returns how many are left."""
    count = beams
    for h in range(beams):
        if held[h, 0] == v and held[h, 1] == omega:
            continue
        _copy(h, count, state, spread, motor, held, moving, moved, weight)
        weight[count] = weight[h] + math.log(lost)
        count += 1
        held[h, 0], held[h, 1] = v, omega
        weight[h] += math.log(1.0 - lost)
    # the unlikeliest go
    while count > most:
        worst = 0
        for h in range(count):
            if weight[h] < weight[worst]:
                worst = h
        count -= 1
        _copy(count, worst, state, spread, motor, held, moving, moved, weight)
    return count


def information(innovation: FloatArray, covariance: FloatArray, steps: FloatArray, score: FloatArray, fisher: FloatArray) -> None:
    """Write each pose's score (N, Q) and the expected information (Q, Q) of a Gaussian model from finite differences.

    Args:
        innovation: (Q + 1, N, 3) at the parameters, then at each parameter's step.
        covariance: (Q + 1, N, 3, 3) likewise.
        steps: (Q,) the steps.
        score: (N, Q) written.
        fisher: (Q, Q) written.
    """
    q = steps.shape[0]
    _information(
        innovation, covariance, steps, np.empty((3, 3)), np.empty(3), np.empty((q, 3)), np.empty((q, 3)), np.empty((q, 3, 3)), score, fisher
    )


@compiled(_nrt=False)
def _information(
    innovation: FloatArray, covariance: FloatArray, steps: FloatArray, inverse: FloatArray, nu: FloatArray, slope: FloatArray,
    weighted: FloatArray, product: FloatArray, score: FloatArray, fisher: FloatArray,
) -> None:  # fmt: skip
    """Do the work of :func:`information`; the arrays between ``steps`` and ``score`` are working space."""
    fisher[:] = 0.0
    for n in range(innovation.shape[1]):
        _invert(covariance[0, n], inverse)
        for a in range(3):
            nu[a] = 0.0
            for b in range(3):
                nu[a] += inverse[a, b] * innovation[0, n, b]
        for i in range(steps.shape[0]):
            value = 0.0
            for a in range(3):
                slope[i, a] = (innovation[i + 1, n, a] - innovation[0, n, a]) / steps[i]
                for c in range(3):
                    change = (covariance[i + 1, n, a, c] - covariance[0, n, a, c]) / steps[i]
                    value += 0.5 * nu[a] * change * nu[c]
                    for b in range(3):
                        product[i, b, c] = inverse[b, a] * change + (product[i, b, c] if a > 0 else 0.0)
            for a in range(3):
                weighted[i, a] = inverse[a, 0] * slope[i, 0] + inverse[a, 1] * slope[i, 1] + inverse[a, 2] * slope[i, 2]
                value -= slope[i, a] * nu[a] + 0.5 * product[i, a, a]
            score[n, i] = value
            for j in range(i + 1):
                value = 0.0
                for a in range(3):
                    value += slope[i, a] * weighted[j, a]
                    for b in range(3):
                        value += 0.5 * product[i, a, b] * product[j, b, a]
                fisher[i, j] += value
    for i in range(steps.shape[0]):
        for j in range(i):
            fisher[j, i] = fisher[i, j]

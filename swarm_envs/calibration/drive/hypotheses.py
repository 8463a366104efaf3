"""The filter's state: hypotheses of which command is in force, each with a pose as likely as the data make it.

Where no command is ever lost there is one. A command that may have been lost makes two of each; those that come to mean the same are
merged, and the unlikeliest go.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from swarm_envs.calibration.arrays import BoolArray, FloatArray
from swarm_envs.compiled import compiled

BEAM = 5
"""Hypotheses of the command in force that are carried along."""
LONG_AGO = -1e9
"""A time in s before every log."""


class Hypotheses(NamedTuple):
    """Room for H hypotheses; the first few count."""

    pose: FloatArray
    """(H, 3) expected measured pose, m, m, rad."""
    covariance: FloatArray
    """(H, 3, 3) of that pose."""
    motors: FloatArray
    """(H, 2) what the motors do, in m/s and rad/s."""
    latched: FloatArray
    """(H, 2) the command in force, in m/s and rad/s."""
    moving: BoolArray
    """(H,) whether it asks for motion."""
    moved: FloatArray
    """(H,) when the robot last moved or was asked to, in s."""
    weight: FloatArray
    """(H,) log of the hypothesis's probability."""
    score: FloatArray
    """(H,) that with the present pose's log-likelihood."""
    innovation: FloatArray
    """(H, 3) the present pose less the expected one."""
    innovation_covariance: FloatArray
    """(H, 3, 3) of that difference."""


def empty_hypotheses() -> Hypotheses:
    """Allocate room for a full beam, each of which may branch."""
    most = 2 * BEAM
    return Hypotheses(
        pose=np.zeros((most, 3)), covariance=np.zeros((most, 3, 3)), motors=np.zeros((most, 2)), latched=np.zeros((most, 2)),
        moving=np.zeros(most, np.bool_), moved=np.zeros(most), weight=np.zeros(most), score=np.zeros(most),
        innovation=np.zeros((most, 3)), innovation_covariance=np.zeros((most, 3, 3)),
    )  # fmt: skip


@compiled(forceinline=True, _nrt=False)
def begin_at_rest(beam: Hypotheses) -> None:
    """Make the first hypothesis a robot at rest without a command."""
    beam.motors[0, 0] = beam.motors[0, 1] = beam.latched[0, 0] = beam.latched[0, 1] = 0.0
    beam.moving[0], beam.moved[0], beam.weight[0] = False, LONG_AGO, 0.0


@compiled(_nrt=False)
def copy(beam: Hypotheses, source: int, goal: int) -> None:
    """Write one hypothesis over another."""
    for i in range(3):
        beam.pose[goal, i] = beam.pose[source, i]
        for j in range(3):
            beam.covariance[goal, i, j] = beam.covariance[source, i, j]
    for i in range(2):
        beam.motors[goal, i], beam.latched[goal, i] = beam.motors[source, i], beam.latched[source, i]
    beam.moving[goal], beam.moved[goal], beam.weight[goal] = beam.moving[source], beam.moved[source], beam.weight[source]


@compiled(_nrt=False)
def restart(beam: Hypotheses, count: int, x: float, y: float, heading: float, place_variance: float, heading_variance: float) -> int:
    """Let all hypotheses start again at a measured pose; returns how many are left, those that move alike from there being one.

    Left apart, the many ways to one command would crowd out the less likely commands, of which one may be in force.
    """
    for h in range(count):
        beam.pose[h, 0], beam.pose[h, 1], beam.pose[h, 2] = x, y, heading
        for i in range(3):
            for j in range(3):
                beam.covariance[h, i, j] = 0.0
        beam.covariance[h, 0, 0] = beam.covariance[h, 1, 1] = place_variance
        beam.covariance[h, 2, 2] = heading_variance
    kept = 0
    for h in range(count):
        same = -1
        for k in range(kept):
            if moves_alike(beam, k, h):
                same = k
                break
        if same >= 0:
            high, low = max(beam.weight[same], beam.weight[h]), min(beam.weight[same], beam.weight[h])
            beam.weight[same] = high + math.log1p(math.exp(low - high))
            beam.moved[same] = max(beam.moved[same], beam.moved[h])
        else:
            if kept != h:
                copy(beam, h, kept)
            kept += 1
    return kept


@compiled(_nrt=False)
def moves_alike(beam: Hypotheses, first: int, second: int) -> bool:
    """Whether two hypotheses move alike from one pose on."""
    if beam.latched[first, 0] != beam.latched[second, 0] or beam.latched[first, 1] != beam.latched[second, 1]:
        return False
    apart_v, apart_omega = beam.motors[first, 0] - beam.motors[second, 0], beam.motors[first, 1] - beam.motors[second, 1]
    return bool(beam.moving[first] == beam.moving[second] and abs(apart_v) < 1e-3 and abs(apart_omega) < 1e-2)


@compiled(_nrt=False)
def branch(beam: Hypotheses, count: int, loss: float, v: float, omega: float) -> int:
    """Let a command arrive, or be lost with probability ``loss``, in every hypothesis; returns how many are left."""
    if loss <= 0.0:
        beam.latched[0, 0], beam.latched[0, 1] = v, omega
        return count
    before = count
    for h in range(before):
        if beam.latched[h, 0] == v and beam.latched[h, 1] == omega:
            continue
        copy(beam, h, count)
        beam.weight[count] = beam.weight[h] + math.log(loss)
        count += 1
        beam.latched[h, 0], beam.latched[h, 1] = v, omega
        beam.weight[h] += math.log(1.0 - loss)
    while count > BEAM:
        worst = 0
        for h in range(count):
            if beam.weight[h] < beam.weight[worst]:
                worst = h
        count -= 1
        copy(beam, count, worst)
    return count

"""One hypothesis of the filter: its pose moved on by the drive's law, and corrected by a measured one."""

from __future__ import annotations

import math

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.drive.hypotheses import Hypotheses
from swarm_envs.calibration.drive.motion import goal_at
from swarm_envs.calibration.drive.noise import ACROSS, ALONG, TURN
from swarm_envs.calibration.drive.parameters import DriveParameters
from swarm_envs.compiled import compiled
from swarm_envs.simulation.drive_law import floor_drift, motion_toward

COMING_TO_REST = 1.0
"""Time in s after the last motion asked for in which a robot still counts as moving."""
RESTING = 0.1
"""Process noise of a robot at rest, as a share of that on the move."""


@compiled(forceinline=True, _nrt=False)
def predict(drive: DriveParameters, noise: FloatArray, factors: FloatArray, beam: Hypotheses, h: int, now: float, dt: float) -> None:
    """Move hypothesis ``h`` by ``dt`` s.

    Args:
        drive: The robot's parameters.
        noise: (5,) standard deviations, see :data:`swarm_envs.calibration.drive.noise.NOISE`.
        factors: (2,) the robot's own factors on both gains.
        beam: The hypotheses.
        h: Index of the one that moves.
        now: Time in s.
        dt: Duration in s.
    """
    pose, covariance, motors = beam.pose[h], beam.covariance[h], beam.motors[h]
    goal_v, goal_omega = goal_at(drive, factors, beam.latched[h, 0], beam.latched[h, 1], now + 0.5 * dt)
    chord, half_turn, motors[0], motors[1] = motion_toward(drive.effects, goal_v, goal_omega, motors[0], motors[1], dt)
    if beam.moving[h] or abs(motors[0]) > 1e-3 or abs(motors[1]) > 1e-2:
        beam.moved[h] = now
    share = dt if now - beam.moved[h] < COMING_TO_REST else dt * RESTING * RESTING
    along, across = share * noise[ALONG] ** 2, share * noise[ACROSS] ** 2
    direction = pose[2] - drive.marker_yaw + half_turn
    c, s = math.cos(direction), math.sin(direction)
    fx, fy = -chord * s, chord * c
    pose[0] += fy
    pose[1] -= fx
    pose[2] += 2.0 * half_turn
    if beam.moving[h]:
        carried_x, carried_y = floor_drift(drive.effects, dt)
        pose[0] += carried_x
        pose[1] += carried_y
    # P = F P F' with F = [[1, 0, fx], [0, 1, fy], [0, 0, 1]]
    p02, p12, p22 = covariance[0, 2], covariance[1, 2], covariance[2, 2]
    covariance[0, 0] += 2.0 * fx * p02 + fx * fx * p22 + along * c * c + across * s * s
    covariance[1, 1] += 2.0 * fy * p12 + fy * fy * p22 + along * s * s + across * c * c
    covariance[0, 1] += fx * p12 + fy * p02 + fx * fy * p22 + (along - across) * c * s
    covariance[0, 2] += fx * p22
    covariance[1, 2] += fy * p22
    covariance[2, 2] += share * noise[TURN] ** 2
    covariance[1, 0], covariance[2, 0], covariance[2, 1] = covariance[0, 1], covariance[0, 2], covariance[1, 2]


@compiled(forceinline=True, _nrt=False)
def correct(beam: Hypotheses, h: int, x: float, y: float, heading: float, place_variance: float, heading_variance: float) -> float:
    """Take a measured pose into hypothesis ``h``, whose innovation is written; returns the pose's log-likelihood."""
    pose, covariance, innovation, expected = beam.pose[h], beam.covariance[h], beam.innovation[h], beam.innovation_covariance[h]
    p00, p01, p02 = covariance[0, 0], covariance[0, 1], covariance[0, 2]
    p11, p12, p22 = covariance[1, 1], covariance[1, 2], covariance[2, 2]
    a, d, f = p00 + place_variance, p11 + place_variance, p22 + heading_variance
    nu0, nu1, nu2 = x - pose[0], y - pose[1], heading - pose[2]
    innovation[0], innovation[1], innovation[2] = nu0, nu1, nu2
    expected[0, 0], expected[1, 1], expected[2, 2] = a, d, f
    expected[0, 1] = expected[1, 0] = p01
    expected[0, 2] = expected[2, 0] = p02
    expected[1, 2] = expected[2, 1] = p12
    i00, i01, i02 = d * f - p12 * p12, p02 * p12 - p01 * f, p01 * p12 - p02 * d
    determinant = a * i00 + p01 * i01 + p02 * i02
    i00, i01, i02 = i00 / determinant, i01 / determinant, i02 / determinant
    i11, i12, i22 = (a * f - p02 * p02) / determinant, (p01 * p02 - a * p12) / determinant, (a * d - p01 * p01) / determinant
    w0, w1, w2 = i00 * nu0 + i01 * nu1 + i02 * nu2, i01 * nu0 + i11 * nu1 + i12 * nu2, i02 * nu0 + i12 * nu1 + i22 * nu2
    pose[0] += p00 * w0 + p01 * w1 + p02 * w2
    pose[1] += p01 * w0 + p11 * w1 + p12 * w2
    pose[2] += p02 * w0 + p12 * w1 + p22 * w2
    # P - P S^-1 P
    g00, g01, g02 = p00 * i00 + p01 * i01 + p02 * i02, p00 * i01 + p01 * i11 + p02 * i12, p00 * i02 + p01 * i12 + p02 * i22
    g10, g11, g12 = p01 * i00 + p11 * i01 + p12 * i02, p01 * i01 + p11 * i11 + p12 * i12, p01 * i02 + p11 * i12 + p12 * i22
    g20, g21, g22 = p02 * i00 + p12 * i01 + p22 * i02, p02 * i01 + p12 * i11 + p22 * i12, p02 * i02 + p12 * i12 + p22 * i22
    covariance[0, 0] = p00 - (g00 * p00 + g01 * p01 + g02 * p02)
    covariance[1, 1] = p11 - (g10 * p01 + g11 * p11 + g12 * p12)
    covariance[2, 2] = p22 - (g20 * p02 + g21 * p12 + g22 * p22)
    covariance[0, 1] = covariance[1, 0] = p01 - (g00 * p01 + g01 * p11 + g02 * p12)
    covariance[0, 2] = covariance[2, 0] = p02 - (g00 * p02 + g01 * p12 + g02 * p22)
    covariance[1, 2] = covariance[2, 1] = p12 - (g10 * p02 + g11 * p12 + g12 * p22)
    squared = nu0 * w0 + nu1 * w1 + nu2 * w2
    return float(-0.5 * (squared + math.log(max(determinant, 1e-300)) + 3.0 * math.log(2.0 * math.pi)))

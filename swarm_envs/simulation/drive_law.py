"""The law of motion of one drive: what becomes of a command, as pure functions on numbers and a robot's effects.

Both engines, calibration's prediction and its filter call these functions and have no formula of their own: an effect acts everywhere
as it is written here. They act in this order: a lost command leaves the previous one in force; dead time delays it
(:func:`time_of_effect`, :func:`ticks_of_delay`); the deadband stops a wheel that is asked for less, turning slows driving, gains (with
each robot's own factor and the drift through a run) scale, saturation clips the rims (:func:`goal_velocity`); the motors lag, the turn
bias follows the driven speed (:func:`motion_toward`); a start from rest kicks (:func:`start_kick`); the floor drifts
(:func:`floor_drift`). While its goal stays a robot moves on an arc of the unicycle.
"""

from __future__ import annotations

import math

from swarm_envs.compiled import compiled
from swarm_envs.simulation.trigonometry import sinc
from swarm_envs.worlds import Effects


@compiled(forceinline=True, _nrt=False)
def time_of_effect(effects: Effects, given: float) -> float:
    """Return when a command acts that was given at a time in s."""
    return given + effects.dead_time


@compiled(forceinline=True, _nrt=False)
def ticks_of_delay(effects: Effects, tick: float) -> tuple[int, float]:
    """Return how late commands act that are given at the start of ticks of ``tick`` s: whole ticks, and the share of one more."""
    late = time_of_effect(effects, 0.0) / tick
    share = late - math.floor(late)
    return math.floor(late + 1e-9), 0.0 if share < 1e-9 or share > 1.0 - 1e-9 else share


@compiled(forceinline=True, _nrt=False)
def goal_velocity(
    effects: Effects, wheel_base: float, linear_factor: float, angular_factor: float, v: float, omega: float, now: float, unit: float
) -> tuple[float, float]:
    """Return what the motors are asked for, v in m/s and omega in rad/s.

    Args:
        effects: The robot's.
        wheel_base: In m.
        linear_factor: The robot's own factor on the linear gain.
        angular_factor: The robot's own factor on the angular gain.
        v: Commanded, in m/s.
        omega: Commanded, in rad/s.
        now: Time since the start of the run in ``unit``.
        unit: A second, 1.0, or another length of time in s.
    """
    v, omega = stand_below_deadband(v, omega, effects.deadband, wheel_base)
    v *= max(0.0, 1.0 - effects.turning_slows * abs(omega))
    left = max(0.0, 1.0 - effects.gain_drift * now * unit)
    v *= effects.linear_gain * linear_factor * left
    omega *= effects.angular_gain * angular_factor * left
    return clip_rims(v, omega, effects.saturation, wheel_base)


@compiled(forceinline=True, _nrt=False)
def stand_below_deadband(v: float, omega: float, threshold: float, wheel_base: float) -> tuple[float, float]:
    """Stop each wheel whose rim is asked for less than ``threshold`` m/s."""
    if threshold == 0.0:
        return v, omega
    left = v - 0.5 * wheel_base * omega
    right = v + 0.5 * wheel_base * omega
    left = 0.0 if abs(left) < threshold else left
    right = 0.0 if abs(right) < threshold else right
    return 0.5 * (left + right), (right - left) / wheel_base


@compiled(forceinline=True, _nrt=False)
def clip_rims(v: float, omega: float, limit: float, wheel_base: float) -> tuple[float, float]:
    """Clip the rim speed of each wheel to ``limit`` m/s."""
    if limit == math.inf:
        return v, omega
    left = min(max(v - 0.5 * wheel_base * omega, -limit), limit)
    right = min(max(v + 0.5 * wheel_base * omega, -limit), limit)
    return 0.5 * (left + right), (right - left) / wheel_base


@compiled(forceinline=True, _nrt=False)
def motion_toward(
    effects: Effects, goal_v: float, goal_omega: float, motor_v: float, motor_omega: float, duration: float
) -> tuple[float, float, float, float]:
    """Return the motion of ``duration`` s toward a goal.

    Args:
        effects: The robot's.
        goal_v: Asked of the motors, in m/s.
        goal_omega: Asked of the motors, in rad/s.
        motor_v: What they do at the start, in m/s.
        motor_omega: What they do at the start, in rad/s.
        duration: In s; the arc is that of the mean speeds, so a lag wants it short against the time constant.

    Returns:
        Length of the arc's chord in m and half the turn in rad, which is the chord's direction from the heading at the start; then
        what the motors do at the end, in m/s and rad/s.
    """
    v, motor_v = first_order(motor_v, goal_v, duration, effects.motor_lag)
    omega, motor_omega = first_order(motor_omega, goal_omega, duration, effects.motor_lag)
    half_turn = 0.5 * (omega + effects.turn_bias * v) * duration
    return chord_speed(v, half_turn) * duration, half_turn, motor_v, motor_omega


@compiled(forceinline=True, _nrt=False)
def first_order(now: float, goal: float, duration: float, time_constant: float) -> tuple[float, float]:
    """Return a first-order response's mean over ``duration`` s and its value after them."""
    if time_constant == 0.0:
        return goal, goal
    left = math.exp(-duration / time_constant)
    return goal + (now - goal) * time_constant / duration * (1.0 - left), goal + (now - goal) * left


@compiled(forceinline=True, _nrt=False)
def chord_speed(v: float, half_turn: float) -> float:
    """Return the mean speed in m/s along the chord of an arc that is driven at ``v`` m/s, half of whose turn is ``half_turn`` rad."""
    return v * sinc(half_turn)


@compiled(forceinline=True, _nrt=False)
def asks_to_move(goal_v: float, goal_omega: float) -> bool:
    """Whether a goal of the motors is not standstill."""
    return goal_v != 0.0 or goal_omega != 0.0


@compiled(forceinline=True, _nrt=False)
def start_kick(effects: Effects, draw: float) -> float:
    """Return the turn in rad at a start from rest, for a draw from the standard normal distribution."""
    return effects.start_kick_mean + effects.start_kick_sd * draw


@compiled(forceinline=True, _nrt=False)
def floor_drift(effects: Effects, duration: float) -> tuple[float, float]:
    """Return how far in m the floor carries a robot that is asked to move, along x and y of the arena, in ``duration`` s."""
    return effects.floor_drift_x * duration, effects.floor_drift_y * duration

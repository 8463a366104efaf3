"""From a command to the motion that the drive would make without contact.

The effects act in this order: a lost command leaves the previous one in force; dead time delays it; the deadband stops a wheel
that is asked for less; turning slows driving; gains (with each robot's own factor and the drift through a run) scale; saturation
clips the rims; the motors lag; the turn bias follows the driven speed; a start from rest kicks; the floor drifts.
Between two changes of its target a robot moves on the exact arc of the unicycle.
"""

from __future__ import annotations

import math

import numpy as np

from swarm_envs.compiled import compiled
from swarm_envs.simulation import parameters as p
from swarm_envs.simulation import scratch as m
from swarm_envs.simulation.parameters import FeatureFlag, FloatArray, WorldArrays
from swarm_envs.simulation.randomness import STREAM_COMMAND_LOSS, STREAM_START_KICK, normal, uniform
from swarm_envs.simulation.scratch import Scratch
from swarm_envs.simulation.state import StateArrays
from swarm_envs.simulation.trigonometry import cos_sin, sinc


@compiled(forceinline=True, _nrt=False)
def give_commands(world: WorldArrays, state: StateArrays, w: int, commands: FloatArray, effects: FeatureFlag) -> None:
    """Hand each robot of world ``w`` its command for this tick.

    Args:
        world: Parameters.
        state: State; ``latched_commands`` and ``command_history`` change.
        w: Index of the world.
        commands: (R, 2) v in m/s and omega in rad/s.
        effects: None for a world without effects.
    """
    tick = state.ticks[w]
    latched = state.latched_commands[w]
    for i in range(latched.shape[0]):
        if effects is None:
            latched[i, 0], latched[i, 1] = commands[i, 0], commands[i, 1]
            continue
        lost = world.robots[i, p.COMMAND_LOSS]
        if lost == 0.0 or uniform(state.keys[w], i, tick, STREAM_COMMAND_LOSS) >= lost:
            latched[i, 0] = commands[i, 0]
            latched[i, 1] = commands[i, 1]
        if not world.ideal_drive:
            slot = tick % world.history
            state.command_history[w, i, slot, 0] = latched[i, 0]
            state.command_history[w, i, slot, 1] = latched[i, 1]


@compiled(forceinline=True, _nrt=False)
def drive(world: WorldArrays, state: StateArrays, w: int, begin: float, end: float, desired: FloatArray, effects: FeatureFlag) -> None:
    """Write the velocity with which each robot would cover [begin, end] of this tick without contact.

    Args:
        world: Parameters.
        state: State; ``drive_velocity`` and ``moving`` change.
        w: Index of the world.
        begin: Share of the tick that has passed, 0 to 1.
        end: Share of the tick at the end of the interval, 0 to 1.
        desired: (R, 3) written: mean vx and vy in m/s in the arena frame (displacement over duration) and omega in rad/s.
        effects: None for a world without effects.
    """
    for i in range(desired.shape[0]):
        drive_robot(world, state, w, i, begin, end, desired, effects)


@compiled(forceinline=True, _nrt=False)
def drive_ideally(world: WorldArrays, state: StateArrays, w: int, scratch: Scratch) -> None:
    """Write into ``scratch.desired_velocity`` the velocity with which each robot, without drive effects, would cover the tick."""
    latched, drive_velocity, columns, desired = state.latched_commands, state.drive_velocity, scratch.columns, scratch.desired_velocity
    robots = desired.shape[0]
    for i in range(robots):
        columns[m.COS, i] = state.poses[w, i, 2] + 0.5 * latched[w, i, 1] * world.tick
    for i in range(robots):  # several at once
        columns[m.COS, i], columns[m.SIN, i] = cos_sin(columns[m.COS, i])
    for i in range(robots):
        v, omega = latched[w, i, 0], latched[w, i, 1]
        chord = v * sinc(0.5 * omega * world.tick)
        desired[i, 0], desired[i, 1], desired[i, 2] = chord * columns[m.COS, i], chord * columns[m.SIN, i], omega
        drive_velocity[w, i, 0], drive_velocity[w, i, 1] = v, omega


@compiled(forceinline=True, _nrt=False)
def drive_robot(
    world: WorldArrays, state: StateArrays, w: int, i: int, begin: float, end: float, desired: FloatArray, effects: FeatureFlag
) -> None:
    """Write the velocity with which robot ``i`` would cover [begin, end] of this tick without contact; see :func:`drive`."""
    if effects is None or world.ideal_drive:
        v, omega = state.latched_commands[w, i, 0], state.latched_commands[w, i, 1]
        half_turn = 0.5 * omega * (end - begin) * world.tick
        c, s = cos_sin(state.poses[w, i, 2] + half_turn)
        chord = v * sinc(half_turn)
        desired[i, 0], desired[i, 1], desired[i, 2] = chord * c, chord * s, omega
        state.drive_velocity[w, i, 0], state.drive_velocity[w, i, 1] = v, omega
    elif state.stalled[w, i]:
        desired[i, 0] = desired[i, 1] = desired[i, 2] = 0.0
        state.drive_velocity[w, i, 0] = state.drive_velocity[w, i, 1] = 0.0
    else:
        drive_with_effects(world, state, w, i, begin, end, desired)


@compiled(_nrt=False)
def drive_with_effects(world: WorldArrays, state: StateArrays, w: int, i: int, begin: float, end: float, desired: FloatArray) -> None:
    """Write robot ``i``'s mean velocity into its row of ``desired`` (R, 3) over [begin, end] of the tick, every effect included."""
    robot = world.robots[i]
    tick = state.ticks[w]
    switch = share_of_switch(robot[p.DEAD_TIME], world.tick)
    heading = state.poses[w, i, 2]
    x = y = turn = 0.0
    pieces = max(1, round((end - begin) * p.MICRO_STEPS)) if robot[p.MOTOR_LAG] > 0.0 else 1
    for k in range(pieces):
        piece_begin = begin + (end - begin) * k / pieces
        piece_end = begin + (end - begin) * (k + 1) / pieces
        at = piece_begin
        while at < piece_end:
            # a delayed command switches inside the tick, at the same share of every tick
            until = switch if at < switch < piece_end else piece_end
            duration = (until - at) * world.tick
            target_v, target_omega, kick = target(world, state, w, i, at >= switch, tick + at)
            v = lagged(state.drive_velocity[w, i, 0], target_v, duration, robot[p.MOTOR_LAG])
            omega = lagged(state.drive_velocity[w, i, 1], target_omega, duration, robot[p.MOTOR_LAG])
            state.drive_velocity[w, i, 0] = settled(state.drive_velocity[w, i, 0], target_v, duration, robot[p.MOTOR_LAG])
            state.drive_velocity[w, i, 1] = settled(state.drive_velocity[w, i, 1], target_omega, duration, robot[p.MOTOR_LAG])
            half_turn = 0.5 * (omega + robot[p.TURN_BIAS] * v) * duration
            direction = heading + turn + kick + half_turn
            chord = v * sinc(half_turn) * duration
            x += chord * math.cos(direction)
            y += chord * math.sin(direction)
            turn += kick + 2.0 * half_turn
            if state.moving[w, i]:
                x += robot[p.FLOOR_DRIFT_X] * duration
                y += robot[p.FLOOR_DRIFT_Y] * duration
            at = until
    span = (end - begin) * world.tick
    desired[i, 0], desired[i, 1], desired[i, 2] = x / span, y / span, turn / span


@compiled(_nrt=False)
def share_of_switch(dead_time: float, tick: float) -> float:
    """Return the share of a tick after which a delayed command takes over, 0 when it does at the tick's start."""
    late = dead_time / tick
    share = late - math.floor(late)
    return 0.0 if share < 1e-9 or share > 1.0 - 1e-9 else share


@compiled(_nrt=False)
def target(world: WorldArrays, state: StateArrays, w: int, i: int, switched: bool, now: float) -> tuple[float, float, float]:
    """Return what the motors are asked for, v in m/s and omega in rad/s, and the turn in rad of a start that happens now.

    Args:
        world: Parameters.
        state: State; ``moving`` changes.
        w: Index of the world.
        i: Index of the robot.
        switched: Whether the tick's own delayed command has taken over from the one before.
        now: Time in ticks since the start.
    """
    robot = world.robots[i]
    age = math.floor(robot[p.DEAD_TIME] / world.tick + 1e-9)
    given = state.ticks[w] - age - (0 if switched else 1)
    v = omega = 0.0
    if given >= 0:
        v = state.command_history[w, i, given % world.history, 0]
        omega = state.command_history[w, i, given % world.history, 1]
    v, omega = stand_below_deadband(v, omega, robot[p.DEADBAND], robot[p.WHEEL_BASE])
    v *= max(0.0, 1.0 - robot[p.TURNING_SLOWS] * abs(omega))
    drifted = max(0.0, 1.0 - robot[p.GAIN_DRIFT] * now * world.tick)
    v *= robot[p.LINEAR_GAIN] * state.gains[w, i, 0] * drifted
    omega *= robot[p.ANGULAR_GAIN] * state.gains[w, i, 1] * drifted
    v, omega = clip_rims(v, omega, robot[p.SATURATION], robot[p.WHEEL_BASE])
    kick = 0.0
    moves = v != 0.0 or omega != 0.0
    if moves and not state.moving[w, i] and (robot[p.START_KICK_MEAN] != 0.0 or robot[p.START_KICK_SD] != 0.0):
        kick = robot[p.START_KICK_MEAN] + robot[p.START_KICK_SD] * normal(state.keys[w], i, state.ticks[w], STREAM_START_KICK)
    state.moving[w, i] = np.uint8(moves)
    return v, omega, kick


@compiled(_nrt=False)
def stand_below_deadband(v: float, omega: float, threshold: float, wheel_base: float) -> tuple[float, float]:
    """Stop each wheel whose rim is asked for less than ``threshold`` m/s."""
    if threshold == 0.0:
        return v, omega
    left = v - 0.5 * wheel_base * omega
    right = v + 0.5 * wheel_base * omega
    left = 0.0 if abs(left) < threshold else left
    right = 0.0 if abs(right) < threshold else right
    return 0.5 * (left + right), (right - left) / wheel_base


@compiled(_nrt=False)
def clip_rims(v: float, omega: float, limit: float, wheel_base: float) -> tuple[float, float]:
    """Clip the rim speed of each wheel to ``limit`` m/s."""
    if limit == math.inf:
        return v, omega
    left = min(max(v - 0.5 * wheel_base * omega, -limit), limit)
    right = min(max(v + 0.5 * wheel_base * omega, -limit), limit)
    return 0.5 * (left + right), (right - left) / wheel_base


@compiled(_nrt=False)
def settled(now: float, goal: float, duration: float, time_constant: float) -> float:
    """Return a first-order response's value after ``duration`` s."""
    return goal if time_constant == 0.0 else goal + (now - goal) * math.exp(-duration / time_constant)


@compiled(_nrt=False)
def lagged(now: float, goal: float, duration: float, time_constant: float) -> float:
    """Return a first-order response's mean over ``duration`` s."""
    if time_constant == 0.0:
        return goal
    return goal + (now - goal) * time_constant / duration * (1.0 - math.exp(-duration / time_constant))

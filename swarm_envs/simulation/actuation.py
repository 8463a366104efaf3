"""From a command to the motion that the drive would make without contact: :mod:`swarm_envs.simulation.drive_law`, tick by tick."""

from __future__ import annotations

import math

import numpy as np

from swarm_envs.compiled import compiled
from swarm_envs.simulation import parameters as p
from swarm_envs.simulation import scratch as m
from swarm_envs.simulation.drive_law import (
    asks_to_move,
    chord_speed,
    floor_drift,
    goal_velocity,
    motion_toward,
    start_kick,
    ticks_of_delay,
)
from swarm_envs.simulation.parameters import FeatureFlag, FloatArray, WorldArrays
from swarm_envs.simulation.randomness import STREAM_COMMAND_LOSS, STREAM_START_KICK, normal, uniform
from swarm_envs.simulation.scratch import Scratch
from swarm_envs.simulation.state import StateArrays
from swarm_envs.simulation.trigonometry import cos_sin


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
        lost = world.effects[i].command_loss
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
        speed = chord_speed(v, 0.5 * omega * world.tick)
        desired[i, 0], desired[i, 1], desired[i, 2] = speed * columns[m.COS, i], speed * columns[m.SIN, i], omega
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
        speed = chord_speed(v, half_turn)
        desired[i, 0], desired[i, 1], desired[i, 2] = speed * c, speed * s, omega
        state.drive_velocity[w, i, 0], state.drive_velocity[w, i, 1] = v, omega
    elif state.stalled[w, i]:
        desired[i, 0] = desired[i, 1] = desired[i, 2] = 0.0
        state.drive_velocity[w, i, 0] = state.drive_velocity[w, i, 1] = 0.0
    else:
        drive_with_effects(world, state, w, i, begin, end, desired)


@compiled(_nrt=False)
def drive_with_effects(world: WorldArrays, state: StateArrays, w: int, i: int, begin: float, end: float, desired: FloatArray) -> None:
    """Write robot ``i``'s mean velocity into its row of ``desired`` (R, 3) over [begin, end] of the tick, every effect included."""
    effects = world.effects[i]
    tick, motors = state.ticks[w], state.drive_velocity[w, i]
    late, switch = ticks_of_delay(effects, world.tick)
    heading = state.poses[w, i, 2]
    x = y = turn = 0.0
    pieces = max(1, round((end - begin) * p.MICRO_STEPS)) if effects.motor_lag > 0.0 else 1
    for k in range(pieces):
        piece_begin = begin + (end - begin) * k / pieces
        piece_end = begin + (end - begin) * (k + 1) / pieces
        at = piece_begin
        while at < piece_end:
            # a delayed command switches inside the tick, at the same share of every tick
            until = switch if at < switch < piece_end else piece_end
            duration = (until - at) * world.tick
            given = tick - late - (0 if at >= switch else 1)
            goal_v, goal_omega, kick = goal(world, state, w, i, given, tick + at)
            chord, half_turn, motors[0], motors[1] = motion_toward(effects, goal_v, goal_omega, motors[0], motors[1], duration)
            direction = heading + turn + kick + half_turn
            x += chord * math.cos(direction)
            y += chord * math.sin(direction)
            turn += kick + 2.0 * half_turn
            if state.moving[w, i]:
                drift_x, drift_y = floor_drift(effects, duration)
                x += drift_x
                y += drift_y
            at = until
    span = (end - begin) * world.tick
    desired[i, 0], desired[i, 1], desired[i, 2] = x / span, y / span, turn / span


@compiled(_nrt=False)
def goal(world: WorldArrays, state: StateArrays, w: int, i: int, given: int, now: float) -> tuple[float, float, float]:
    """Return what the motors are asked for, v in m/s and omega in rad/s, and the turn in rad of a start that happens now.

    Args:
        world: Parameters.
        state: State; ``moving`` changes.
        w: Index of the world.
        i: Index of the robot.
        given: The tick whose command is in force.
        now: Time in ticks since the start.
    """
    effects, factors = world.effects[i], state.gains[w, i]
    v = omega = 0.0
    if given >= 0:
        v = state.command_history[w, i, given % world.history, 0]
        omega = state.command_history[w, i, given % world.history, 1]
    v, omega = goal_velocity(effects, world.robots[i, p.WHEEL_BASE], factors[0], factors[1], v, omega, now, world.tick)
    kick = 0.0
    moves = asks_to_move(v, omega)
    if moves and not state.moving[w, i] and (effects.start_kick_mean != 0.0 or effects.start_kick_sd != 0.0):
        kick = start_kick(effects, normal(state.keys[w], i, state.ticks[w], STREAM_START_KICK))
    state.moving[w, i] = np.uint8(moves)
    return v, omega, kick

"""The order of a tick, compiled: command, stall, drive, contact, clock, sense. The same for both engines."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from swarm_envs.compiled import compiled
from swarm_envs.simulation.actuation import give_commands
from swarm_envs.simulation.broadcast import broadcast_detections, receive_broadcast
from swarm_envs.simulation.chipmunk import engine as chipmunk
from swarm_envs.simulation.chipmunk.spaces import SpaceArrays
from swarm_envs.simulation.contacts import stall_wheels
from swarm_envs.simulation.disc import engine as disc
from swarm_envs.simulation.grid import GRID_FROM
from swarm_envs.simulation.parameters import FeatureFlag, FloatArray, WorldArrays
from swarm_envs.simulation.scratch import Scratch
from swarm_envs.simulation.sensing import sense
from swarm_envs.simulation.state import StateArrays

ByteArray = npt.NDArray[np.uint8]


def feature_flags(world: WorldArrays) -> tuple[FeatureFlag, FeatureFlag]:
    """Return ``effects`` and ``grid`` of :func:`advance_world`: what a world needs to have compiled."""
    plain = world.ideal_drive and world.ideal_sensing and world.broadcast_range == 0.0
    return None if plain else True, True if len(world.robots) >= GRID_FROM else None


@compiled(inline="always", _nrt=False)
def advance_world(
    world: WorldArrays,
    state: StateArrays,
    spaces: SpaceArrays | None,
    effects: FeatureFlag,
    grid: FeatureFlag,
    w: int,
    commands: FloatArray,
    scratch: Scratch,
) -> None:
    """Run world ``w`` through one tick.

    Args:
        world: Parameters.
        state: State of all worlds.
        spaces: Chipmunk's memory; None for the disc engine. Each engine is compiled without the other.
        effects: None for a world of ideal drives and sensors that broadcasts nothing.
        grid: None for a swarm of fewer than ``GRID_FROM`` robots.
        w: Index of the world.
        commands: (R, 2) v in m/s and omega in rad/s.
        scratch: Scratch memory.
    """
    give_commands(world, state, w, commands, effects)
    if effects is not None and not world.ideal_drive:
        stall_wheels(world, state, w)
    if spaces is None:
        disc.advance(world, state, w, scratch, effects, grid)
    else:
        chipmunk.advance(world, state, spaces, w, scratch, effects)
    state.ticks[w] += 1
    sense(world, state, w, scratch, effects, grid)
    if effects is not None and world.broadcast_range > 0.0:
        receive_broadcast(world, state, w)


@compiled(_nrt=False)
def step_worlds(
    world: WorldArrays,
    state: StateArrays,
    spaces: SpaceArrays | None,
    effects: FeatureFlag,
    grid: FeatureFlag,
    commands: FloatArray,
    scratch: Scratch,
) -> None:
    """Run every world through one tick with its own commands (W, R, 2)."""
    for w in range(commands.shape[0]):
        advance_world(world, state, spaces, effects, grid, w, commands[w], scratch)


@compiled(_nrt=False)
def run_worlds(
    world: WorldArrays, state: StateArrays, spaces: SpaceArrays | None, effects: FeatureFlag, grid: FeatureFlag, controllers: FloatArray,
    steps: int, every: int, scratch: Scratch, poses: FloatArray, detections: ByteArray, commands: FloatArray,
) -> None:  # fmt: skip
    """Run each world with its controllers and record frames.

    Args:
        world: Parameters.
        state: State of W worlds, started and sensed.
        spaces: Chipmunk's memory; None for the disc engine.
        effects: See :func:`advance_world`.
        grid: See :func:`advance_world`.
        controllers: (W, R, 2 * 2^K) pairs (v, omega) in m/s and rad/s; the pair's index is the number that K readings write in binary.
            Where the world has a broadcast, a robot sends whether its sensors report something.
        steps: Ticks to run.
        every: Ticks from one recorded frame to the next.
        scratch: Scratch memory.
        poses: (W, F, R, 3) written.
        detections: (W, F, R, S) written; S + 1 with a broadcast.
        commands: (W, F, R, 2) written: what each robot does about the frame's detections.
    """
    now = scratch.commands
    for w in range(controllers.shape[0]):
        for k in range(steps + 1):
            control(state.detections[w], controllers[w], now)
            if k % every == 0:
                record(state, w, now, k // every, poses, detections, commands)
            if k < steps:
                if effects is not None and world.broadcast_range > 0.0:
                    broadcast_detections(state, w)
                advance_world(world, state, spaces, effects, grid, w, now, scratch)


@compiled(inline="always", _nrt=False)
def record(state: StateArrays, w: int, now: FloatArray, frame: int, poses: FloatArray, detections: ByteArray, commands: FloatArray) -> None:
    """Write one frame of world ``w``, whose robots do ``now`` (R, 2)."""
    for i in range(now.shape[0]):
        for k in range(3):
            poses[w, frame, i, k] = state.poses[w, i, k]
        for s in range(state.detections.shape[2]):
            detections[w, frame, i, s] = state.detections[w, i, s]
        for k in range(2):
            commands[w, frame, i, k] = now[i, k]


@compiled(inline="always", _nrt=False)
def control(detections: ByteArray, controllers: FloatArray, commands: FloatArray) -> None:
    """Write each robot's command (R, 2) for its readings (R, S): the if-else controller of the paper, one pair per pattern."""
    inputs = 1
    while 2 << inputs < controllers.shape[1]:
        inputs += 1
    for i in range(controllers.shape[0]):
        pattern = 0
        for s in range(inputs):
            pattern += int(detections[i, s]) << s
        commands[i, 0] = controllers[i, 2 * pattern]
        commands[i, 1] = controllers[i, 2 * pattern + 1]


@compiled(_nrt=False)
def sense_worlds(
    world: WorldArrays, state: StateArrays, which: npt.NDArray[np.int64], scratch: Scratch, effects: FeatureFlag, grid: FeatureFlag
) -> None:
    """Take the first readings of the worlds with these indices."""
    for w in which:
        sense(world, state, w, scratch, effects, grid)
        if effects is not None and world.broadcast_range > 0.0:
            receive_broadcast(world, state, w)

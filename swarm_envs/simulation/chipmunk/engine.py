"""A tick of the Chipmunk engine."""

from __future__ import annotations

from swarm_envs.compiled import compiled
from swarm_envs.simulation.actuation import drive
from swarm_envs.simulation.chipmunk.calls import (
    BODIES,
    EACH_BODY,
    GET_BATCH,
    GET_DATA,
    MOVE_BODY,
    SET_BATCH,
    SET_BIAS,
    SET_DATA,
    SPACE,
    STEP,
    call_with_double,
    call_with_pointers,
)
from swarm_envs.simulation.chipmunk.prediction import (
    BLOCKED,
    SOLVED_X,
    SOLVED_Y,
    TURN_BY_CONTACT,
    commands_changed,
    contacts_persist,
    predict_velocities,
    record_solution,
    time_of_impact,
    turn_to_midpoint,
)
from swarm_envs.simulation.chipmunk.spaces import SpaceArrays
from swarm_envs.simulation.chipmunk.substeps import LATTICE, collision_bias, substeps_needed
from swarm_envs.simulation.grid import LARGE_SWARM
from swarm_envs.simulation.parameters import FeatureFlag, FloatArray, WorldArrays
from swarm_envs.simulation.scratch import Scratch
from swarm_envs.simulation.state import StateArrays


@compiled(inline="always", _nrt=False)
def advance(world: WorldArrays, state: StateArrays, spaces: SpaceArrays, w: int, scratch: Scratch, effects: FeatureFlag) -> None:
    """Move the robots and objects of world ``w`` through one tick with contact."""
    desired = scratch.desired_velocity
    handles = spaces.handles[w]
    counters = spaces.counters[w]
    predicted = spaces.predicted[w]
    known = world.objects.shape[0] == 0 and desired.shape[0] <= LARGE_SWARM
    predict_velocities(world, state, w, predicted)
    substeps = substeps_needed(world, state.poses[w], predicted, spaces.substeps) if known else spaces.substeps
    if commands_changed(world, state, w, predicted):
        # what contact did tells nothing of what it will do now
        for i in range(desired.shape[0]):
            predicted[i, BLOCKED] = predicted[i, TURN_BY_CONTACT] = 0.0
        predict_velocities(world, state, w, predicted)
    longest = (LATTICE + substeps - 1) // substeps if substeps > 0 else LATTICE
    at = 0
    while at < LATTICE:
        until = min(LATTICE, at + longest)
        if substeps > 0 and desired.shape[0] <= LARGE_SWARM:
            if at > 0:
                predict_velocities(world, state, w, predicted)
            impact = time_of_impact(world, state.poses[w], predicted)
            if impact * LATTICE < (until - at) * world.tick:
                until = at + int(impact / world.tick * LATTICE) + 1
        duration = (until - at) * world.tick / LATTICE
        drive(world, state, w, at / LATTICE, until / LATTICE, desired, effects)
        turn_to_midpoint(desired, predicted, duration)
        ahead = 0.5 * duration if known and contacts_persist(world, state.poses[w], predicted, 0.5 * duration) else 0.0
        write_bodies(world, state, w, desired, predicted, ahead, spaces.set_values[w])
        counters[4] = 0
        call_with_pointers(handles[EACH_BODY], handles[SPACE], handles[SET_BATCH], handles[SET_DATA])
        # bodies are given velocities, so the impulses that Chipmunk remembers hold whatever a substep's length: its step is always the same
        solver_step = world.tick / spaces.substeps
        call_with_double(handles[SET_BIAS], handles[SPACE], collision_bias(duration, solver_step))
        call_with_double(handles[STEP], handles[SPACE], solver_step)
        for b in range(BODIES, handles.shape[0]):
            call_with_double(handles[MOVE_BODY], handles[b], duration)
        counters[0] = 0
        call_with_pointers(handles[EACH_BODY], handles[SPACE], handles[GET_BATCH], handles[GET_DATA])
        read_bodies(state, w, spaces.set_values[w], spaces.get_values[w])
        record_solution(predicted, desired, spaces.get_values[w])
        at = until


@compiled(forceinline=True, _nrt=False)
def write_bodies(
    world: WorldArrays, state: StateArrays, w: int, desired: FloatArray, predicted: FloatArray, ahead: float, values: FloatArray
) -> None:
    """Lay out what the solver starts from: desired velocities, and robots where they will be after ``ahead`` s."""
    robots = desired.shape[0]
    for i in range(robots):
        values[5 * i] = state.poses[w, i, 0] + ahead * predicted[i, SOLVED_X]
        values[5 * i + 1] = state.poses[w, i, 1] + ahead * predicted[i, SOLVED_Y]
        for k in range(3):
            values[5 * i + 2 + k] = desired[i, k]
    for b in range(world.objects.shape[0]):
        at = 5 * (robots + b)
        values[at], values[at + 1] = state.objects[w, b, 0], state.objects[w, b, 1]
        for k in range(3):
            values[at + 2 + k] = state.objects[w, b, 3 + k]


@compiled(forceinline=True, _nrt=False)
def read_bodies(state: StateArrays, w: int, given: FloatArray, values: FloatArray) -> None:
    """Copy poses of robots and poses and velocities of objects out of the batch; robots moved from where they were, not where given."""
    robots = state.poses.shape[1]
    for i in range(robots):
        for k in range(2):
            state.poses[w, i, k] += values[6 * i + k] - given[5 * i + k]
        state.poses[w, i, 2] = values[6 * i + 2]
    for b in range(state.objects.shape[1]):
        for k in range(6):
            state.objects[w, b, k] = values[6 * (robots + b) + k]

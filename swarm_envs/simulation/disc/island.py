"""The contact island: robots that touch each other, or several walls, through one tick."""

from __future__ import annotations

import math

import numpy as np

from swarm_envs.compiled import compiled
from swarm_envs.simulation.disc.contact import (
    FIRST_RADIUS,
    GAP,
    NORMAL_IMPULSE,
    NORMAL_X,
    NORMAL_Y,
    SECOND_RADIUS,
    update_contact,
)
from swarm_envs.simulation.disc.motion import CLOSED_GAP, LATTICE, drive_part, predicted_velocity
from swarm_envs.simulation.disc.solver import TOLERANCE, solve
from swarm_envs.simulation.grid import LARGE_SWARM
from swarm_envs.simulation.parameters import FeatureFlag, FloatArray, WorldArrays
from swarm_envs.simulation.scratch import Scratch
from swarm_envs.simulation.state import StateArrays
from swarm_envs.simulation.trigonometry import cos_sin_small

ISLAND = -2
"""What ``Scratch.assignment`` holds for a robot of the contact island."""


@compiled(forceinline=True, _nrt=False)
def advance_island(world: WorldArrays, state: StateArrays, w: int, scratch: Scratch, count: int, effects: FeatureFlag) -> None:
    """Move the robots of the contact island through one tick, in two parts where some first touch within it."""
    poses, assignment, velocity, desired = state.poses[w], scratch.assignment, scratch.velocity, scratch.desired_velocity
    robots = assignment.shape[0]
    at = int(np.int64(0))  # a plain 0 is another type, for which callees would be compiled, too
    while at < LATTICE:
        until = LATTICE
        if at > 0:
            for k in range(count):
                update_contact(world, poses, scratch, k)
        elif robots <= LARGE_SWARM:
            until = first_impact(world, state, w, scratch, count, effects)
        duration = (until - at) * world.tick / LATTICE
        for i in range(robots):
            if assignment[i] == ISLAND:
                drive_part(world, state, w, i, at, until, scratch, effects)
                for k in range(3):
                    velocity[i, k] = desired[i, k]
        if solve(duration, scratch, count, 5.0 * TOLERANCE):
            midpoint_step(poses, duration, scratch, count)
            for i in range(robots):
                for k in range(3):
                    velocity[i, k] = desired[i, k]
            solve(duration, scratch, count, TOLERANCE)
        for i in range(robots):
            if assignment[i] == ISLAND:
                for k in range(3):
                    poses[i, k] += velocity[i, k] * duration
        at = until


@compiled(forceinline=True, _nrt=False)
def first_impact(world: WorldArrays, state: StateArrays, w: int, scratch: Scratch, count: int, effects: FeatureFlag) -> int:
    """Return the point of the tick's lattice at or before which contacts that are apart first touch, else the tick's end.

    Robots are taken to drive straight on; a touch before the lattice's first point divides nothing.
    """
    poses, velocity = state.poses[w], scratch.velocity
    robots = poses.shape[0]
    for i in range(robots):
        if scratch.assignment[i] == ISLAND:
            velocity[i, 0], velocity[i, 1] = predicted_velocity(world, state, w, i, scratch, effects)
    time_of_impact = world.tick
    for k in range(count):
        i, j = scratch.contact_pairs[k, 0], scratch.contact_pairs[k, 1]
        contact = scratch.contacts[k]
        gap = contact[GAP]
        if gap <= CLOSED_GAP:
            continue
        vx, vy = velocity[j, 0] - velocity[i, 0], velocity[j, 1] - velocity[i, 1]
        closing = -(vx * contact[NORMAL_X] + vy * contact[NORMAL_Y])
        if closing <= 0.0:
            continue
        if j == robots:
            time_of_impact = min(time_of_impact, gap / closing)
        else:
            touch = contact[FIRST_RADIUS] + contact[SECOND_RADIUS]
            approach, squared = closing * (gap + touch), vx * vx + vy * vy
            inside = approach * approach - squared * gap * (gap + 2.0 * touch)
            if inside > 0.0:
                time_of_impact = min(time_of_impact, (approach - math.sqrt(inside)) / squared)
    first = int(time_of_impact / world.tick * LATTICE)
    return first if first > 0 else LATTICE


@compiled(forceinline=True, _nrt=False)
def midpoint_step(poses: FloatArray, duration: float, scratch: Scratch, count: int) -> None:
    """Turn desired velocities and normals to the middle of the motion of ``duration`` s that the first solution leads through."""
    half, desired, solved, contacts = 0.5 * duration, scratch.desired_velocity, scratch.velocity, scratch.contacts
    robots = desired.shape[0]
    for i in range(robots):
        turned = (solved[i, 2] - desired[i, 2]) * half
        if scratch.assignment[i] == ISLAND and turned != 0.0:
            c, s = cos_sin_small(turned)
            desired[i, 0], desired[i, 1] = c * desired[i, 0] - s * desired[i, 1], s * desired[i, 0] + c * desired[i, 1]
    for k in range(count):
        i, j = scratch.contact_pairs[k, 0], scratch.contact_pairs[k, 1]
        if j == robots or contacts[k, NORMAL_IMPULSE] == 0.0:
            continue
        dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
        mx, my = dx + (solved[j, 0] - solved[i, 0]) * half, dy + (solved[j, 1] - solved[i, 1]) * half
        length = math.sqrt(mx * mx + my * my)
        if length > 1e-9:
            contacts[k, NORMAL_X], contacts[k, NORMAL_Y] = mx / length, my / length
            # the gap along the new normal: what the new normal sees of the distance, less the two radii
            contacts[k, GAP] = (dx * mx + dy * my) / length - contacts[k, FIRST_RADIUS] - contacts[k, SECOND_RADIUS]

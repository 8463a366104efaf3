"""A tick of the disc engine: each robot is assigned to the cheapest solution that its contacts allow."""

from __future__ import annotations

import numpy as np

from swarm_envs.compiled import compiled
from swarm_envs.simulation.actuation import drive_ideally
from swarm_envs.simulation.disc.broad_phase import find_contacts
from swarm_envs.simulation.disc.contact import WIDTH
from swarm_envs.simulation.disc.island import ISLAND, advance_island
from swarm_envs.simulation.disc.motion import move_freely
from swarm_envs.simulation.disc.single_wall import slide_on_wall
from swarm_envs.simulation.parameters import FeatureFlag, WorldArrays
from swarm_envs.simulation.scratch import Scratch
from swarm_envs.simulation.state import StateArrays

FREE = -1
"""What ``Scratch.assignment`` holds for a robot with nothing near; the index of its contact for one with a single wall near."""


@compiled(inline="always", _nrt=False)
def advance(world: WorldArrays, state: StateArrays, w: int, scratch: Scratch, effects: FeatureFlag, grid: FeatureFlag) -> None:
    """Move the robots of world ``w`` through one tick with contact; ``poses`` of the state change."""
    poses = state.poses[w]
    count = find_contacts(world, poses, scratch, grid)
    if effects is None or world.ideal_drive:
        drive_ideally(world, state, w, scratch)
    if count > 0:
        advance_in_contact(world, state, w, scratch, count, effects)
    else:
        for i in range(poses.shape[0]):
            move_freely(world, state, w, i, scratch, effects)


@compiled(_nrt=False)
def advance_in_contact(world: WorldArrays, state: StateArrays, w: int, scratch: Scratch, count: int, effects: FeatureFlag) -> None:
    """Move the robots of world ``w`` through one tick in which ``count`` contacts could close."""
    assignment, contact_pairs = scratch.assignment, scratch.contact_pairs
    robots = assignment.shape[0]
    for i in range(robots):
        assignment[i] = FREE
    for k in range(count):
        i, j = contact_pairs[k, 0], contact_pairs[k, 1]
        if j < robots:
            assignment[i] = assignment[j] = ISLAND
        else:
            assignment[i] = k if assignment[i] == FREE else ISLAND
    has_island = False
    for i in range(robots):
        if assignment[i] == FREE:
            move_freely(world, state, w, i, scratch, effects)
        elif assignment[i] == ISLAND:
            has_island = True
        else:
            slide_on_wall(world, state, w, i, scratch, effects)
    if has_island:
        kept = int(np.int64(0))  # a plain 0 is another type, for which callees would be compiled, too
        for k in range(count):
            if assignment[contact_pairs[k, 0]] == ISLAND:
                if kept != k:
                    for c in range(WIDTH):
                        scratch.contacts[kept, c] = scratch.contacts[k, c]
                    for c in range(3):
                        contact_pairs[kept, c] = contact_pairs[k, c]
                kept += 1
        advance_island(world, state, w, scratch, kept, effects)

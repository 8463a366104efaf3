"""A robot's motion through a tick, or a part of it, without contact."""

from __future__ import annotations

from swarm_envs.compiled import compiled
from swarm_envs.simulation import parameters as p
from swarm_envs.simulation.actuation import drive_robot
from swarm_envs.simulation.parameters import FeatureFlag, WorldArrays
from swarm_envs.simulation.scratch import Scratch
from swarm_envs.simulation.state import StateArrays
from swarm_envs.simulation.trigonometry import cos_sin

LATTICE = p.MICRO_STEPS
"""A tick is divided only on this lattice."""
CLOSED_GAP = 1e-6
"""A gap in m that counts as closed already: no part of a tick begins with its closing."""


@compiled(forceinline=True, _nrt=False)
def move_freely(world: WorldArrays, state: StateArrays, w: int, i: int, scratch: Scratch, effects: FeatureFlag) -> None:
    """Move one robot through a tick without contact."""
    desired = scratch.desired_velocity
    if effects is not None and not world.ideal_drive:
        drive_robot(world, state, w, i, 0.0, 1.0, desired, effects)
    for k in range(3):
        state.poses[w, i, k] += desired[i, k] * world.tick


@compiled(forceinline=True, _nrt=False)
def drive_part(world: WorldArrays, state: StateArrays, w: int, i: int, at: int, until: int, scratch: Scratch, effects: FeatureFlag) -> None:
    """Write into ``scratch.desired_velocity`` with which velocity robot ``i`` would cover a part of the tick without contact."""
    # the whole tick of an ideal drive is there already
    if until - at < LATTICE or (effects is not None and not world.ideal_drive):
        drive_robot(world, state, w, i, at / LATTICE, until / LATTICE, scratch.desired_velocity, effects)


@compiled(forceinline=True, _nrt=False)
def predicted_velocity(
    world: WorldArrays, state: StateArrays, w: int, i: int, scratch: Scratch, effects: FeatureFlag
) -> tuple[float, float]:
    """Velocity with which robot ``i`` sets out on a tick: an ideal drive's mean one, else where it is heading as fast as it goes."""
    if effects is None or world.ideal_drive:
        return scratch.desired_velocity[i, 0], scratch.desired_velocity[i, 1]
    c, s = cos_sin(state.poses[w, i, 2])
    return state.drive_velocity[w, i, 0] * c, state.drive_velocity[w, i, 0] * s

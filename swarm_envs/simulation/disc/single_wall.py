"""A robot that nothing but one wall is near, in closed form."""

from __future__ import annotations

import numpy as np

from swarm_envs.compiled import compiled
from swarm_envs.simulation.disc.contact import (
    FIRST_ARM_OVER_INERTIA,
    FIRST_INVERSE_MASS,
    FIRST_RADIUS,
    FRICTION,
    GAP,
    NORMAL_MASS,
    NORMAL_X,
    NORMAL_Y,
    RESTITUTION,
    TANGENT_MASS,
)
from swarm_envs.simulation.disc.motion import CLOSED_GAP, LATTICE, drive_part, predicted_velocity
from swarm_envs.simulation.parameters import FeatureFlag, FloatArray, WorldArrays
from swarm_envs.simulation.scratch import Scratch
from swarm_envs.simulation.state import StateArrays
from swarm_envs.simulation.trigonometry import cos_sin_small


@compiled(forceinline=True, _nrt=False)
def slide_on_wall(world: WorldArrays, state: StateArrays, w: int, i: int, scratch: Scratch, effects: FeatureFlag) -> None:
    """Move a robot with one wall near through a tick, in two parts where it first touches within it.

    A normal impulse does not change how fast the contact point slides, nor a tangential one how fast the gap closes:
    one after the other they are the solution.
    """
    desired = scratch.desired_velocity
    contact = scratch.contacts[scratch.assignment[i]]
    nx, ny, gap = contact[NORMAL_X], contact[NORMAL_Y], contact[GAP]
    at = int(np.int64(0))  # a plain 0 is another type, for which callees would be compiled, too
    while at < LATTICE:
        until = LATTICE
        if at == 0 and gap > CLOSED_GAP:
            vx, vy = predicted_velocity(world, state, w, i, scratch, effects)
            closing = vx * nx + vy * ny
            if closing * world.tick > gap:
                first = int(gap / closing / world.tick * LATTICE)
                until = first if first > 0 else LATTICE
        drive_part(world, state, w, i, at, until, scratch, effects)
        duration = (until - at) * world.tick / LATTICE
        vx, vy, omega = desired[i, 0], desired[i, 1], desired[i, 2]
        closing = vx * nx + vy * ny
        allowed = gap / duration
        if closing > allowed:
            resolved = resolve_wall_contact(contact, nx, ny, vx, vy, omega, allowed)
            c, s = cos_sin_small(0.5 * duration * (resolved[2] - omega))
            vx, vy = c * vx - s * vy, s * vx + c * vy
            closing = vx * nx + vy * ny
            if closing > allowed:
                vx, vy, omega = resolve_wall_contact(contact, nx, ny, vx, vy, omega, allowed)
        state.poses[w, i, 0] += vx * duration
        state.poses[w, i, 1] += vy * duration
        state.poses[w, i, 2] += omega * duration
        gap -= (vx * nx + vy * ny) * duration
        at = until


@compiled(forceinline=True, _nrt=False)
def resolve_wall_contact(
    contact: FloatArray, nx: float, ny: float, vx: float, vy: float, omega: float, allowed: float
) -> tuple[float, float, float]:
    """Return the velocity nearest to (vx, vy, omega) that closes the gap of a wall, along (nx, ny), no faster than ``allowed``."""
    closing = vx * nx + vy * ny
    allowed = min(allowed, -contact[RESTITUTION] * closing) if contact[RESTITUTION] > 0.0 else allowed
    normal_impulse = (closing - allowed) * contact[NORMAL_MASS]
    slip = vy * nx - vx * ny + contact[FIRST_RADIUS] * omega
    bound = contact[FRICTION] * normal_impulse
    tangential_impulse = min(max(slip * contact[TANGENT_MASS], -bound), bound)
    inverse_mass = contact[FIRST_INVERSE_MASS]
    vx -= inverse_mass * (nx * normal_impulse - ny * tangential_impulse)
    vy -= inverse_mass * (ny * normal_impulse + nx * tangential_impulse)
    return vx, vy, omega - contact[FIRST_ARM_OVER_INERTIA] * tangential_impulse

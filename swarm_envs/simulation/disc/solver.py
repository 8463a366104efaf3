"""Sequential impulses: the velocities of robots in contact, solved together."""

from __future__ import annotations

from swarm_envs.compiled import compiled
from swarm_envs.simulation.disc.contact import (
    FIRST_ARM_OVER_INERTIA,
    FIRST_INVERSE_MASS,
    FIRST_RADIUS,
    FRICTION,
    GAP,
    NORMAL_IMPULSE,
    NORMAL_MASS,
    NORMAL_X,
    NORMAL_Y,
    RESTITUTION,
    SECOND_ARM_OVER_INERTIA,
    SECOND_INVERSE_MASS,
    SECOND_RADIUS,
    TANGENT_MASS,
    TANGENTIAL_IMPULSE,
    TARGET_OPENING,
)
from swarm_envs.simulation.grid import LARGE_SWARM
from swarm_envs.simulation.parameters import FloatArray
from swarm_envs.simulation.scratch import IntArray, Scratch

MAX_ITERATIONS = 200
"""Most passes over the contacts in one tick."""
OVER_RELAXATION, OVER_RELAXED_PASSES = 1.25, 10
"""Factor of successive over-relaxation in the passes after the first, up to so many: contacts that lean on each other settle in fewer.
Piles of great friction would never settle so."""
TOLERANCE = 1e-4
"""Passes end when none changed a closing distance by more than this many metres."""


@compiled(_nrt=False)
def solve(duration: float, scratch: Scratch, count: int, tolerance: float) -> bool:
    """Change the contact island's velocities so that no contact closes more than its gap, with friction and restitution.

    Args:
        duration: Of the motion in s.
        scratch: Velocities without contact, changed; contacts, whose impulses are applied first, so that a second solution starts
            from the first.
        count: Number of contacts.
        tolerance: Passes end when none changed a closing distance by more than this many m.

    Returns:
        Whether any contact needed an impulse.
    """
    velocity, contacts, contact_pairs, active_pass = scratch.velocity, scratch.contacts, scratch.contact_pairs, scratch.active_pass
    if not set_targets(duration, scratch, count):
        return False
    for k in range(count):
        if contacts[k, NORMAL_IMPULSE] > 0.0:
            apply_impulses(velocity, contacts, contact_pairs, k, contacts[k, NORMAL_IMPULSE], contacts[k, TANGENTIAL_IMPULSE])
    # in a large swarm piles settle one after the other; in a small one looking who has settled costs more than it saves
    wall, many = active_pass.shape[0] - 1, active_pass.shape[0] > LARGE_SWARM
    if many:
        for i in range(active_pass.shape[0]):
            active_pass[i] = 0
    for number in range(1, MAX_ITERATIONS + 1):
        relaxation = OVER_RELAXATION if 1 < number < OVER_RELAXED_PASSES else 1.0
        change = 0.0
        for k in range(count):
            i, j = contact_pairs[k, 0], contact_pairs[k, 1]
            if many and active_pass[i] < number - 1 and active_pass[j] < number - 1:
                continue  # no impulse has moved either since they were last looked at
            by = solve_contact(velocity, contacts, i, j, k, relaxation) * duration
            change = max(change, by)
            if many and by >= tolerance:
                active_pass[i] = number
                if j != wall:
                    active_pass[j] = number
        if change < tolerance:
            break
    return True


@compiled(forceinline=True, _nrt=False)
def set_targets(duration: float, scratch: Scratch, count: int) -> bool:
    """Write the velocity in m/s with which each contact must open at least; return whether any needs an impulse for that."""
    velocity, contacts, contact_pairs = scratch.velocity, scratch.contacts, scratch.contact_pairs
    active = False
    for k in range(count):
        opening = opening_speed(velocity, contacts, contact_pairs, k)
        contacts[k, TARGET_OPENING] = -contacts[k, GAP] / duration
        if opening < contacts[k, TARGET_OPENING]:
            active = True
            if contacts[k, RESTITUTION] > 0.0:
                contacts[k, TARGET_OPENING] = max(contacts[k, TARGET_OPENING], -contacts[k, RESTITUTION] * opening)
        active = active or contacts[k, NORMAL_IMPULSE] > 0.0
    return active


@compiled(forceinline=True, _nrt=False)
def solve_contact(velocity: FloatArray, contacts: FloatArray, i: int, j: int, k: int, relaxation: float) -> float:
    """Change the impulses of contact ``k``, of robot ``i`` with robot or wall ``j``, and the velocities that follow from them.

    Args:
        velocity: (R + 1, 3), changed.
        contacts: (C, 16), changed.
        i: Index of the first robot.
        j: Index of the second, R for a wall.
        k: Index of the contact.
        relaxation: Share of what the contact lacks that it is given.

    Returns:
        By how much the velocity of the contact point changed, in m/s.
    """
    before = contacts[k, NORMAL_IMPULSE]
    nx, ny = contacts[k, NORMAL_X], contacts[k, NORMAL_Y]
    inverse_mass, other_inverse_mass = contacts[k, FIRST_INVERSE_MASS], contacts[k, SECOND_INVERSE_MASS]
    # read once: the compiler cannot know that what is written below is not what is read again
    ix, iy, omega = velocity[i, 0], velocity[i, 1], velocity[i, 2]
    jx, jy, other_omega = velocity[j, 0], velocity[j, 1], velocity[j, 2]
    vx, vy = jx - ix, jy - iy
    normal_impulse = max(0.0, before + relaxation * (contacts[k, TARGET_OPENING] - (vx * nx + vy * ny)) * contacts[k, NORMAL_MASS])
    if normal_impulse == 0.0 and before == 0.0:
        return 0.0
    friction_before, bound = contacts[k, TANGENTIAL_IMPULSE], contacts[k, FRICTION] * normal_impulse
    slip = vy * nx - vx * ny - contacts[k, FIRST_RADIUS] * omega - contacts[k, SECOND_RADIUS] * other_omega
    friction_impulse = min(max(friction_before - relaxation * slip * contacts[k, TANGENT_MASS], -bound), bound)
    along, across = normal_impulse - before, friction_impulse - friction_before
    contacts[k, NORMAL_IMPULSE], contacts[k, TANGENTIAL_IMPULSE] = normal_impulse, friction_impulse
    x, y = nx * along - ny * across, ny * along + nx * across
    velocity[i, 0], velocity[i, 1] = ix - inverse_mass * x, iy - inverse_mass * y
    velocity[i, 2] = omega - contacts[k, FIRST_ARM_OVER_INERTIA] * across
    velocity[j, 0], velocity[j, 1] = jx + other_inverse_mass * x, jy + other_inverse_mass * y
    velocity[j, 2] = other_omega - contacts[k, SECOND_ARM_OVER_INERTIA] * across
    both_inverse_masses = inverse_mass + other_inverse_mass
    arms_over_inertia = (
        contacts[k, FIRST_RADIUS] * contacts[k, FIRST_ARM_OVER_INERTIA] + contacts[k, SECOND_RADIUS] * contacts[k, SECOND_ARM_OVER_INERTIA]
    )
    return float(max(abs(along) * both_inverse_masses, abs(across) * (both_inverse_masses + arms_over_inertia)))


@compiled(forceinline=True, _nrt=False)
def opening_speed(velocity: FloatArray, contacts: FloatArray, contact_pairs: IntArray, k: int) -> float:
    """Velocity in m/s with which contact ``k`` opens."""
    i, j = contact_pairs[k, 0], contact_pairs[k, 1]
    vx, vy = velocity[j, 0] - velocity[i, 0], velocity[j, 1] - velocity[i, 1]
    return float(vx * contacts[k, NORMAL_X] + vy * contacts[k, NORMAL_Y])


@compiled(forceinline=True, _nrt=False)
def apply_impulses(velocity: FloatArray, contacts: FloatArray, contact_pairs: IntArray, k: int, along: float, across: float) -> None:
    """Apply impulses in kg m/s along the normal of contact ``k``, and counter-clockwise from it."""
    i, j = contact_pairs[k, 0], contact_pairs[k, 1]
    nx, ny = contacts[k, NORMAL_X], contacts[k, NORMAL_Y]
    x, y = nx * along - ny * across, ny * along + nx * across
    velocity[i, 0] -= contacts[k, FIRST_INVERSE_MASS] * x
    velocity[i, 1] -= contacts[k, FIRST_INVERSE_MASS] * y
    velocity[i, 2] -= contacts[k, FIRST_ARM_OVER_INERTIA] * across
    velocity[j, 0] += contacts[k, SECOND_INVERSE_MASS] * x
    velocity[j, 1] += contacts[k, SECOND_INVERSE_MASS] * y
    velocity[j, 2] -= contacts[k, SECOND_ARM_OVER_INERTIA] * across

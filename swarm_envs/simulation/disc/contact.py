"""A contact of two robots, or of a robot and a wall, as a row of ``Scratch.contacts``; its columns are the constants below."""

from __future__ import annotations

import math

from swarm_envs.compiled import compiled
from swarm_envs.simulation import parameters as p
from swarm_envs.simulation.parameters import FloatArray, WorldArrays
from swarm_envs.simulation.scratch import Scratch
from swarm_envs.simulation.segments import offset_from_segment

(
    NORMAL_X,
    NORMAL_Y,
    GAP,
    FRICTION,
    RESTITUTION,
    NORMAL_IMPULSE,
    TANGENTIAL_IMPULSE,
    TARGET_OPENING,
    NORMAL_MASS,  # kg that an impulse along the normal moves
    TANGENT_MASS,  # kg that an impulse across it moves, spins included
    FIRST_INVERSE_MASS,  # 1 / kg of the first robot
    FIRST_ARM_OVER_INERTIA,  # rad/s of the first robot for an impulse across
    FIRST_RADIUS,
    SECOND_INVERSE_MASS,  # these three are 0 for walls
    SECOND_ARM_OVER_INERTIA,
    SECOND_RADIUS,
) = range(16)
WIDTH = 16

OUT_OF_REACH = 1e9
"""Gap in m of a wall that a robot cannot touch within a tick."""


@compiled(forceinline=True, _nrt=False)
def add_robot_contact(world: WorldArrays, poses: FloatArray, i: int, j: int, scratch: Scratch, found: int) -> int:
    """Append the contact of robots ``i`` and ``j`` if they are near; return the number of contacts."""
    dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
    near = world.robots[i, p.RADIUS] + world.robots[j, p.RADIUS] + 2.0 * world.reach
    if dx * dx + dy * dy >= near * near or found >= scratch.contacts.shape[0]:
        return found
    contact, first, second = scratch.contacts[found], world.robots[i], world.robots[j]
    distance = math.sqrt(dx * dx + dy * dy)
    scratch.contact_pairs[found, 0], scratch.contact_pairs[found, 1] = i, j
    # two centres in one place have no normal: any will do to part them
    contact[NORMAL_X] = dx / distance if distance > 1e-12 else 1.0
    contact[NORMAL_Y] = dy / distance if distance > 1e-12 else 0.0
    contact[GAP] = distance - first[p.RADIUS] - second[p.RADIUS]
    contact[FRICTION], contact[RESTITUTION] = world.contact[p.ROBOT_FRICTION], world.contact[p.ROBOT_RESTITUTION]
    contact[NORMAL_IMPULSE] = contact[TANGENTIAL_IMPULSE] = 0.0
    contact[FIRST_INVERSE_MASS], contact[SECOND_INVERSE_MASS] = first[p.INVERSE_MASS], second[p.INVERSE_MASS]
    contact[FIRST_ARM_OVER_INERTIA], contact[SECOND_ARM_OVER_INERTIA] = first[p.ARM_OVER_INERTIA], second[p.ARM_OVER_INERTIA]
    contact[FIRST_RADIUS], contact[SECOND_RADIUS] = first[p.RADIUS], second[p.RADIUS]
    inverse_mass = contact[FIRST_INVERSE_MASS] + contact[SECOND_INVERSE_MASS]
    contact[NORMAL_MASS] = 1.0 / inverse_mass
    contact[TANGENT_MASS] = 1.0 / (
        inverse_mass + contact[FIRST_RADIUS] * contact[FIRST_ARM_OVER_INERTIA] + contact[SECOND_RADIUS] * contact[SECOND_ARM_OVER_INERTIA]
    )
    return found + 1


@compiled(forceinline=True, _nrt=False)
def add_wall_contact(world: WorldArrays, poses: FloatArray, i: int, e: int, scratch: Scratch, found: int) -> int:
    """Append the contact of robot ``i`` with wall ``e`` if it is near; return the number of contacts."""
    if found >= scratch.contacts.shape[0]:
        return found
    nx, ny, gap = wall_contact(world, poses, i, e)
    if gap == OUT_OF_REACH:
        return found
    contact, robot = scratch.contacts[found], world.robots[i]
    scratch.contact_pairs[found, 0], scratch.contact_pairs[found, 1], scratch.contact_pairs[found, 2] = i, poses.shape[0], e
    contact[NORMAL_X], contact[NORMAL_Y], contact[GAP] = nx, ny, gap
    contact[FRICTION], contact[RESTITUTION] = world.contact[p.WALL_FRICTION], world.contact[p.WALL_RESTITUTION]
    contact[NORMAL_IMPULSE] = contact[TANGENTIAL_IMPULSE] = 0.0
    contact[FIRST_INVERSE_MASS], contact[FIRST_ARM_OVER_INERTIA], contact[FIRST_RADIUS] = (
        robot[p.INVERSE_MASS],
        robot[p.ARM_OVER_INERTIA],
        robot[p.RADIUS],
    )
    contact[SECOND_INVERSE_MASS] = contact[SECOND_ARM_OVER_INERTIA] = contact[SECOND_RADIUS] = 0.0
    contact[NORMAL_MASS], contact[TANGENT_MASS] = robot[p.MASS], robot[p.TANGENT_MASS]
    return found + 1


@compiled(forceinline=True, _nrt=False)
def wall_contact(world: WorldArrays, poses: FloatArray, i: int, e: int) -> tuple[float, float, float]:
    """Return the direction from robot ``i`` to wall ``e`` and the gap in m, ``OUT_OF_REACH`` if the wall is of no concern."""
    wall, radius = world.walls[e], world.robots[i, p.RADIUS]
    px, py = poses[i, 0] - wall[p.START_X], poses[i, 1] - wall[p.START_Y]
    ux, uy, length = wall[p.ALONG_X], wall[p.ALONG_Y], wall[p.LENGTH]
    distance, along = ux * py - uy * px, px * ux + py * uy
    nx, ny = uy, -ux
    if along < 0.0 or along > length:
        # beyond an end only the corner itself is there, and it matters only where it juts into the free side
        cx, cy = offset_from_segment(px, py, ux, uy, 1.0, length)
        across = math.sqrt(cx * cx + cy * cy)
        if distance < 0.0 or across > radius + world.reach or across < 1e-12:
            return nx, ny, OUT_OF_REACH
        nx, ny, distance = -cx / across, -cy / across, across
    if distance < -radius:
        return nx, ny, OUT_OF_REACH
    return nx, ny, distance - radius


@compiled(forceinline=True, _nrt=False)
def update_contact(world: WorldArrays, poses: FloatArray, scratch: Scratch, k: int) -> None:
    """Measure contact ``k`` again where its robots are by now."""
    i, j, contact = scratch.contact_pairs[k, 0], scratch.contact_pairs[k, 1], scratch.contacts[k]
    contact[NORMAL_IMPULSE] = contact[TANGENTIAL_IMPULSE] = 0.0
    if j == poses.shape[0]:
        contact[NORMAL_X], contact[NORMAL_Y], contact[GAP] = wall_contact(world, poses, i, scratch.contact_pairs[k, 2])
    else:
        dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
        distance = math.sqrt(dx * dx + dy * dy)
        if distance > 1e-12:
            contact[NORMAL_X], contact[NORMAL_Y] = dx / distance, dy / distance
        contact[GAP] = distance - contact[FIRST_RADIUS] - contact[SECOND_RADIUS]

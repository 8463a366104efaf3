"""The contact law for discs in a polygon, compiled: speculative contacts solved by sequential impulses.

A robot wishes a velocity; contact changes the wishes as little as possible in the mass metric. A pair may close its gap within the
tick and no more, so a full tick of 0.1 s needs no substeps: with v_n the relative velocity along the normal, v_n >= -gap / dt.
Discs and straight walls only get farther apart than the linearised gap says, whatever the normal, so a solved tick does not overlap.
A tick is solved twice: first to see where it leads, then with the normals and headings of its middle, which makes sliding and
turning contacts accurate to second order.
Friction is Coulomb's on the velocity of the contact points, spins included, bounded by the normal impulse.
"""

from __future__ import annotations

import math

import numpy as np

from swarm_envs.compiled import compiled
from swarm_envs.simulation import parameters as p
from swarm_envs.simulation.actuation import drive
from swarm_envs.simulation.grid import IntArray, bins
from swarm_envs.simulation.parameters import FloatArray, WorldArrays
from swarm_envs.simulation.state import StateArrays
from swarm_envs.simulation.touching import LARGE, time_to_touch

MAX_ITERATIONS = 200
"""Most passes over the contacts in one tick."""
TOLERANCE = 1e-4
"""Passes end when none changed a closing distance by more than this many metres."""
LATTICE = p.MICRO_STEPS
"""A tick is divided only on this lattice."""
GRID_FROM = 40
"""With this many robots or more, pairs are found through a grid."""

# Columns of a contact.
FIRST, SECOND, NORMAL_X, NORMAL_Y, GAP, FRICTION, RESTITUTION, PUSH, DRAG, TARGET = range(10)
WALL = -1.0


@compiled(forceinline=True)
def advance(world: WorldArrays, state: StateArrays, w: int, wish: FloatArray, contacts: FloatArray) -> None:
    """Move the robots of world ``w`` through one tick with contact, in two parts where some first touch within it.

    Args:
        world: Parameters.
        state: State; ``poses`` change.
        w: Index of the world.
        wish: (R, 3) scratch memory.
        contacts: (C, 10) scratch memory; C bounds the number of contacts.
    """
    poses = state.poses[w]
    at = 0
    while at < LATTICE:
        count = find_contacts(world, poses, contacts)
        until = LATTICE
        if count > 0 and poses.shape[0] <= LARGE:
            touch = time_to_touch(world, poses, state.held[w] if world.ideal_drive else state.motion[w])
            if touch < (LATTICE - at) * world.tick / LATTICE:
                first = int(touch / world.tick * LATTICE)
                until = at + first if first > 0 else LATTICE
        drive(world, state, w, at / LATTICE, until / LATTICE, wish)
        move(world, poses, (until - at) * world.tick / LATTICE, wish, contacts, count)
        at = until


@compiled(forceinline=True)
def move(world: WorldArrays, poses: FloatArray, duration: float, wish: FloatArray, contacts: FloatArray, count: int) -> None:
    """Move robots (R, 3) for ``duration`` s with the velocities nearest to ``wish`` (R, 3) that the contacts allow."""
    if count > 0:
        free = wish.copy()
        if solve(world.robots, duration, wish, contacts, count, 5.0 * TOLERANCE):
            to_middle(world, poses, duration, free, wish, contacts, count)
            wish[:] = free
            solve(world.robots, duration, wish, contacts, count, TOLERANCE)
    for i in range(poses.shape[0]):
        for k in range(3):
            poses[i, k] += wish[i, k] * duration


@compiled(forceinline=True)
def to_middle(
    world: WorldArrays, poses: FloatArray, duration: float, free: FloatArray, solved: FloatArray, contacts: FloatArray, count: int
) -> None:
    """Turn wishes and normals to the middle of the motion that the first solution ``solved`` leads through.

    Args:
        world: Parameters.
        poses: (R, 3) at its start.
        duration: Of the motion in s.
        free: (R, 3) velocities without contact; turned with the headings.
        solved: (R, 3) velocities of the first solution.
        contacts: (C, 10) normals and gaps change.
        count: Number of contacts.
    """
    half = 0.5 * duration
    for i in range(free.shape[0]):
        turned = (solved[i, 2] - free[i, 2]) * half
        if turned != 0.0:
            c, s = math.cos(turned), math.sin(turned)
            free[i, 0], free[i, 1] = c * free[i, 0] - s * free[i, 1], s * free[i, 0] + c * free[i, 1]
    for k in range(count):
        i, j = int(contacts[k, FIRST]), int(contacts[k, SECOND])
        if j < 0 or contacts[k, PUSH] == 0.0:
            continue
        dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
        mx, my = dx + (solved[j, 0] - solved[i, 0]) * half, dy + (solved[j, 1] - solved[i, 1]) * half
        length = math.sqrt(mx * mx + my * my)
        if length > 1e-9:
            contacts[k, NORMAL_X], contacts[k, NORMAL_Y] = mx / length, my / length
            # the gap along the new normal: what the new normal sees of the distance, less the two radii
            contacts[k, GAP] = (dx * mx + dy * my) / length - world.robots[i, p.RADIUS] - world.robots[j, p.RADIUS]


@compiled(forceinline=True)
def find_contacts(world: WorldArrays, poses: FloatArray, contacts: FloatArray) -> int:
    """Write every contact that could close within a tick; return their number."""
    robots, walls = world.robots, world.walls
    count = poses.shape[0]
    found = 0
    if count >= GRID_FROM:
        found = find_pairs_with_grid(world, poses, contacts)
    else:
        for i in range(count):
            for j in range(i):
                dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
                near = robots[i, p.RADIUS] + robots[j, p.RADIUS] + 2.0 * world.reach
                if dx * dx + dy * dy < near * near:
                    found = add_pair(world, i, j, dx, dy, contacts, found)
    for i in range(count):
        near = robots[i, p.RADIUS] + world.reach
        for e in range(walls.shape[0]):
            px, py = poses[i, 0] - walls[e, p.START_X], poses[i, 1] - walls[e, p.START_Y]
            # the wall's free side is to its left: positive distances from its line
            distance = walls[e, p.ALONG_X] * py - walls[e, p.ALONG_Y] * px
            if -near < distance < near:
                found = add_wall(world, i, e, px, py, distance, contacts, found)
    return found


@compiled(forceinline=True)
def add_pair(world: WorldArrays, i: int, j: int, dx: float, dy: float, contacts: FloatArray, found: int) -> int:
    """Append the contact of robots ``i`` and ``j``, (dx, dy) from one to the other; return the number of contacts."""
    if found >= contacts.shape[0]:
        return found
    distance = math.sqrt(dx * dx + dy * dy)
    contacts[found, FIRST], contacts[found, SECOND] = i, j
    # two centres in one place have no normal: any will do to part them
    contacts[found, NORMAL_X] = dx / distance if distance > 1e-12 else 1.0
    contacts[found, NORMAL_Y] = dy / distance if distance > 1e-12 else 0.0
    contacts[found, GAP] = distance - world.robots[i, p.RADIUS] - world.robots[j, p.RADIUS]
    contacts[found, PUSH] = contacts[found, DRAG] = 0.0
    contacts[found, FRICTION] = world.contact[p.ROBOT_FRICTION]
    contacts[found, RESTITUTION] = world.contact[p.ROBOT_RESTITUTION]
    return found + 1


@compiled(forceinline=True)
def add_wall(world: WorldArrays, i: int, e: int, px: float, py: float, distance: float, contacts: FloatArray, found: int) -> int:
    """Append the contact of robot ``i`` with wall ``e`` if it is near; return the number of contacts.

    Args:
        world: Parameters.
        i: Index of the robot.
        e: Index of the wall.
        px: Robot's centre from the wall's start along x, in m.
        py: Robot's centre from the wall's start along y, in m.
        distance: Of the robot's centre from the wall's line in m, positive on the free side.
        contacts: (C, 10) written.
        found: Number of contacts so far.
    """
    radius = world.robots[i, p.RADIUS]
    ux, uy, length = world.walls[e, p.ALONG_X], world.walls[e, p.ALONG_Y], world.walls[e, p.LENGTH]
    along = px * ux + py * uy
    nx, ny = uy, -ux
    if along < 0.0 or along > length:
        # beyond an end only the corner itself is there, and it matters only where it juts into the free side
        cx, cy = px - ux * min(max(along, 0.0), length), py - uy * min(max(along, 0.0), length)
        across = math.sqrt(cx * cx + cy * cy)
        if distance < 0.0 or across > radius + world.reach or across < 1e-12:
            return found
        nx, ny, distance = -cx / across, -cy / across, across
    if distance < -radius or found >= contacts.shape[0]:
        return found
    contacts[found, FIRST], contacts[found, SECOND] = i, WALL
    contacts[found, NORMAL_X], contacts[found, NORMAL_Y], contacts[found, GAP] = nx, ny, distance - radius
    contacts[found, PUSH] = contacts[found, DRAG] = 0.0
    contacts[found, FRICTION] = world.contact[p.WALL_FRICTION]
    contacts[found, RESTITUTION] = world.contact[p.WALL_RESTITUTION]
    return found + 1


@compiled()
def find_pairs_with_grid(world: WorldArrays, poses: FloatArray, contacts: FloatArray) -> int:
    """Append the near pairs of a large swarm, looking only into neighbouring cells."""
    low_x, low_y = poses[:, 0].min(), poses[:, 1].min()
    width, height = poses[:, 0].max() - low_x, poses[:, 1].max() - low_y
    cell = max(2.0 * (world.robots[:, p.RADIUS].max() + world.reach), 0.5 * math.sqrt((width * height + 1e-6) / poses.shape[0]))
    columns, rows = int(width / cell) + 1, int(height / cell) + 1
    first, order = bins(poses, low_x, low_y, cell, columns, rows)
    found = 0
    for i in range(poses.shape[0]):
        column = int((poses[i, 0] - low_x) / cell)
        row = int((poses[i, 1] - low_y) / cell)
        for r in range(max(0, row - 1), min(rows, row + 2)):
            for c in range(max(0, column - 1), min(columns, column + 2)):
                found = add_cell(world, poses, i, order, first[r * columns + c], first[r * columns + c + 1], contacts, found)
    return found


@compiled()
def add_cell(world: WorldArrays, poses: FloatArray, i: int, order: IntArray, begin: int, end: int, contacts: FloatArray, found: int) -> int:
    """Append the near pairs of robot ``i`` with the robots of one cell that come before it."""
    for k in range(begin, end):
        j = order[k]
        dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
        near = world.robots[i, p.RADIUS] + world.robots[j, p.RADIUS] + 2.0 * world.reach
        if j < i and dx * dx + dy * dy < near * near:
            found = add_pair(world, i, j, dx, dy, contacts, found)
    return found


@compiled()
def solve(robots: FloatArray, duration: float, velocity: FloatArray, contacts: FloatArray, count: int, tolerance: float) -> bool:
    """Change the velocities (R, 3) so that no contact closes more than its gap, with friction and restitution.

    Args:
        robots: Parameters of the robots.
        duration: Of the motion in s.
        velocity: (R, 3) without contact; changed.
        contacts: (C, 10); impulses that they hold are applied first, so a second solution starts from the first.
        count: Number of contacts.
        tolerance: Passes end when none changed a closing distance by more than this many m.

    Returns:
        Whether any contact had to push.
    """
    for k in range(count):
        closing = normal_velocity(velocity, contacts, k)
        contacts[k, TARGET] = -contacts[k, GAP] / duration
        if closing < contacts[k, TARGET] and contacts[k, RESTITUTION] > 0.0:
            contacts[k, TARGET] = max(contacts[k, TARGET], -contacts[k, RESTITUTION] * closing)
    for k in range(count):
        if contacts[k, PUSH] > 0.0:
            push_apart(robots, velocity, contacts, k, contacts[k, PUSH])
            drag_along(robots, velocity, contacts, k, contacts[k, DRAG])
    for passes in range(MAX_ITERATIONS):
        change = 0.0
        for k in range(count):
            change = max(change, solve_contact(robots, velocity, contacts, k))
        if change * duration < tolerance:
            return passes > 0 or change > 0.0
    return True


@compiled(inline="always")
def normal_velocity(velocity: FloatArray, contacts: FloatArray, k: int) -> float:
    """Velocity in m/s with which contact ``k`` opens."""
    i, j = int(contacts[k, FIRST]), int(contacts[k, SECOND])
    vx, vy = -velocity[i, 0], -velocity[i, 1]
    if j >= 0:
        vx += velocity[j, 0]
        vy += velocity[j, 1]
    return float(vx * contacts[k, NORMAL_X] + vy * contacts[k, NORMAL_Y])


@compiled(inline="always")
def push_apart(robots: FloatArray, velocity: FloatArray, contacts: FloatArray, k: int, impulse: float) -> None:
    """Apply a normal impulse in kg m/s at contact ``k``."""
    i, j = int(contacts[k, FIRST]), int(contacts[k, SECOND])
    nx, ny = contacts[k, NORMAL_X] * impulse, contacts[k, NORMAL_Y] * impulse
    velocity[i, 0] -= robots[i, p.INVERSE_MASS] * nx
    velocity[i, 1] -= robots[i, p.INVERSE_MASS] * ny
    if j >= 0:
        velocity[j, 0] += robots[j, p.INVERSE_MASS] * nx
        velocity[j, 1] += robots[j, p.INVERSE_MASS] * ny


@compiled(inline="always")
def drag_along(robots: FloatArray, velocity: FloatArray, contacts: FloatArray, k: int, impulse: float) -> None:
    """Apply a tangential impulse in kg m/s at contact ``k``, counter-clockwise from its normal."""
    i, j = int(contacts[k, FIRST]), int(contacts[k, SECOND])
    tx, ty = -contacts[k, NORMAL_Y] * impulse, contacts[k, NORMAL_X] * impulse
    velocity[i, 0] -= robots[i, p.INVERSE_MASS] * tx
    velocity[i, 1] -= robots[i, p.INVERSE_MASS] * ty
    velocity[i, 2] -= robots[i, p.SPIN] * impulse
    if j >= 0:
        velocity[j, 0] += robots[j, p.INVERSE_MASS] * tx
        velocity[j, 1] += robots[j, p.INVERSE_MASS] * ty
        velocity[j, 2] -= robots[j, p.SPIN] * impulse


@compiled(inline="always")
def solve_contact(robots: FloatArray, velocity: FloatArray, contacts: FloatArray, k: int) -> float:
    """Apply the normal, then the tangential impulse that contact ``k`` lacks; return the largest change of velocity in m/s."""
    i, j = int(contacts[k, FIRST]), int(contacts[k, SECOND])
    inverse = robots[i, p.INVERSE_MASS] + (robots[j, p.INVERSE_MASS] if j >= 0 else 0.0)
    before = contacts[k, PUSH]
    push = max(0.0, before + (contacts[k, TARGET] - normal_velocity(velocity, contacts, k)) / inverse)
    contacts[k, PUSH] = push
    change = abs(push - before) * inverse
    if change > 0.0:
        push_apart(robots, velocity, contacts, k, push - before)
    if contacts[k, FRICTION] > 0.0 and (push > 0.0 or contacts[k, DRAG] != 0.0):
        # the contact point lies at +radius along the normal of the first and at -radius of the second
        tx, ty = -contacts[k, NORMAL_Y], contacts[k, NORMAL_X]
        slip = -(velocity[i, 0] * tx + velocity[i, 1] * ty + robots[i, p.RADIUS] * velocity[i, 2])
        inverse += robots[i, p.RADIUS] * robots[i, p.SPIN]
        if j >= 0:
            slip += velocity[j, 0] * tx + velocity[j, 1] * ty - robots[j, p.RADIUS] * velocity[j, 2]
            inverse += robots[j, p.RADIUS] * robots[j, p.SPIN]
        bound = contacts[k, FRICTION] * push
        before = contacts[k, DRAG]
        drag = min(max(before - slip / inverse, -bound), bound)
        contacts[k, DRAG] = drag
        drag_along(robots, velocity, contacts, k, drag - before)
        change = max(change, abs(drag - before) * inverse)
    return float(change)


def contact_capacity(world: WorldArrays) -> int:
    """A bound on the contacts of one tick.

    A robot's partners have their centres within two radii and two reaches, and discs do not overlap: their number is bounded by areas.
    """
    radii, count = world.robots[:, p.RADIUS], len(world.robots)
    around = (2.0 * radii.max() + 2.0 * world.reach + radii.min()) / radii.min()
    pairs = count * min(count - 1, math.ceil(around * around)) // 2
    return int(pairs + count * len(world.walls) + 1)


def scratch(world: WorldArrays) -> FloatArray:
    """Allocate the memory for one world's contacts."""
    return np.empty((contact_capacity(world), 10))

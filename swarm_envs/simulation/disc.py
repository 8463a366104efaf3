"""The contact law for discs in a polygon, compiled: speculative contacts solved by sequential impulses.

Each robot has a desired velocity; contact changes these as little as possible in the mass metric. A pair may close its gap within the
tick and no more, so a full tick of 0.1 s needs no substeps: with v_n the relative velocity along the normal, v_n >= -gap / dt.
Discs and straight walls only get farther apart than the linearised gap says, whatever the normal, so a solved tick does not overlap.
A tick is solved twice: first to see where it leads, then with the normals and headings of its middle, which makes sliding and
turning contacts accurate to second order.
Friction is Coulomb's on the velocity of the contact points, spins included, bounded by the normal impulse.

A tick costs what happens in it: a robot with nothing near drives its arc; one with a single wall near is solved in closed form, since
nobody else is concerned; the others, the contact island, are solved together.
"""

from __future__ import annotations

import math

import numpy as np

from swarm_envs.compiled import compiled
from swarm_envs.simulation import parameters as p
from swarm_envs.simulation import scratch as m
from swarm_envs.simulation.actuation import drive_ideally, drive_robot
from swarm_envs.simulation.grid import bins, bounds
from swarm_envs.simulation.parameters import FeatureFlag, FloatArray, WorldArrays
from swarm_envs.simulation.scratch import IntArray, Scratch, scratch_for
from swarm_envs.simulation.state import StateArrays
from swarm_envs.simulation.touching import LARGE_SWARM
from swarm_envs.simulation.trigonometry import cos_sin, cos_sin_small

MAX_ITERATIONS = 200
"""Most passes over the contacts in one tick."""
OVER_RELAXATION, OVER_RELAXED_PASSES = 1.25, 10
"""Factor of successive over-relaxation in the passes after the first, up to so many: contacts that lean on each other settle in fewer.
Piles of great friction would never settle so."""
TOLERANCE = 1e-4
"""Passes end when none changed a closing distance by more than this many metres."""
LATTICE = p.MICRO_STEPS
"""A tick is divided only on this lattice."""
CLOSED_GAP = 1e-6
"""A gap in m that counts as closed already: no part of a tick begins with its closing."""

# Columns of a contact.
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

# Which solver a robot is assigned to, in Scratch.assignment: values from 0 are the only contact's index.
FREE, ISLAND = -1, -2
OUT_OF_REACH = 1e9
"""Gap in m of a wall that a robot cannot touch within a tick."""


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


@compiled(forceinline=True, _nrt=False)
def find_contacts(world: WorldArrays, poses: FloatArray, scratch: Scratch, grid: FeatureFlag) -> int:
    """Write every contact that could close within a tick; return their number."""
    robots, walls, columns = world.robots, world.walls, scratch.columns
    count = poses.shape[0]
    for i in range(count):
        columns[m.X, i], columns[m.Y, i] = poses[i, 0], poses[i, 1]
        columns[m.EXTENT, i] = robots[i, p.RADIUS] + world.reach
    found = int(np.int64(0))
    if grid is not None:
        found = find_pairs_with_grid(world, poses, scratch)
    else:
        for i in range(1, count):
            x, y, near = columns[m.X, i], columns[m.Y, i], columns[m.EXTENT, i]
            # few are near: one look at all without a branch, then one by one
            close = 0
            for j in range(count):
                dx, dy, both = columns[m.X, j] - x, columns[m.Y, j] - y, columns[m.EXTENT, j] + near
                close += dx * dx + dy * dy < both * both
            if close > 1:
                for j in range(i):
                    found = add_robot_contact(world, poses, i, j, scratch, found)
    for e in range(walls.shape[0]):
        x, y, ux, uy = walls[e, p.START_X], walls[e, p.START_Y], walls[e, p.ALONG_X], walls[e, p.ALONG_Y]
        close = 0
        for i in range(count):
            # the wall's free side is to its left: positive distances from its line
            close += abs(ux * (columns[m.Y, i] - y) - uy * (columns[m.X, i] - x)) < columns[m.EXTENT, i]
        if close > 0:
            for i in range(count):
                if abs(ux * (columns[m.Y, i] - y) - uy * (columns[m.X, i] - x)) < columns[m.EXTENT, i]:
                    found = add_wall_contact(world, poses, i, e, scratch, found)
    return found


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
        cx, cy = px - ux * min(max(along, 0.0), length), py - uy * min(max(along, 0.0), length)
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


@compiled()
def find_pairs_with_grid(world: WorldArrays, poses: FloatArray, scratch: Scratch) -> int:
    """Append the near pairs of a large swarm, looking only into neighbouring cells."""
    low_x, low_y, width, height = bounds(poses)
    widest = 0.0
    for i in range(poses.shape[0]):
        widest = max(widest, scratch.columns[m.EXTENT, i])
    cell = max(2.0 * widest, 0.5 * math.sqrt((width * height + 1e-6) / poses.shape[0]))
    columns, rows = int(width / cell) + 1, int(height / cell) + 1
    first, order = bins(poses, low_x, low_y, cell, columns, rows)
    found = int(np.int64(0))
    for i in range(poses.shape[0]):
        column = int((poses[i, 0] - low_x) / cell)
        row = int((poses[i, 1] - low_y) / cell)
        for r in range(max(0, row - 1), min(rows, row + 2)):
            # the cells of a row are neighbours in the order, too
            for k in range(first[r * columns + max(0, column - 1)], first[r * columns + min(columns, column + 2)]):
                if order[k] < i:
                    found = add_robot_contact(world, poses, i, order[k], scratch, found)
    return found


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
    wall = active_pass.shape[0] - 1
    active = False
    for k in range(count):
        opening = opening_speed(velocity, contacts, contact_pairs, k)
        contacts[k, TARGET_OPENING] = -contacts[k, GAP] / duration
        if opening < contacts[k, TARGET_OPENING]:
            active = True
            if contacts[k, RESTITUTION] > 0.0:
                contacts[k, TARGET_OPENING] = max(contacts[k, TARGET_OPENING], -contacts[k, RESTITUTION] * opening)
        active = active or contacts[k, NORMAL_IMPULSE] > 0.0
    if not active:
        return False
    for k in range(count):
        if contacts[k, NORMAL_IMPULSE] > 0.0:
            apply_impulses(velocity, contacts, contact_pairs, k, contacts[k, NORMAL_IMPULSE], contacts[k, TANGENTIAL_IMPULSE])
    # in a large swarm piles settle one after the other; in a small one looking who has settled costs more than it saves
    many = active_pass.shape[0] > LARGE_SWARM
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
            before = contacts[k, NORMAL_IMPULSE]
            nx, ny = contacts[k, NORMAL_X], contacts[k, NORMAL_Y]
            inverse_mass, other_inverse_mass = contacts[k, FIRST_INVERSE_MASS], contacts[k, SECOND_INVERSE_MASS]
            # read once: the compiler cannot know that what is written below is not what is read again
            ix, iy, omega = velocity[i, 0], velocity[i, 1], velocity[i, 2]
            jx, jy, other_omega = velocity[j, 0], velocity[j, 1], velocity[j, 2]
            vx, vy = jx - ix, jy - iy
            normal_impulse = max(0.0, before + relaxation * (contacts[k, TARGET_OPENING] - (vx * nx + vy * ny)) * contacts[k, NORMAL_MASS])
            if normal_impulse == 0.0 and before == 0.0:
                continue
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
                contacts[k, FIRST_RADIUS] * contacts[k, FIRST_ARM_OVER_INERTIA]
                + contacts[k, SECOND_RADIUS] * contacts[k, SECOND_ARM_OVER_INERTIA]
            )
            by = max(abs(along) * both_inverse_masses, abs(across) * (both_inverse_masses + arms_over_inertia)) * duration
            change = max(change, by)
            if many and by >= tolerance:
                active_pass[i] = number
                if j != wall:
                    active_pass[j] = number
        if change < tolerance:
            break
    return True


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


def contact_capacity(world: WorldArrays) -> int:
    """A bound on the contacts of one tick.

    A robot's partners have their centres within two radii and two reaches, and discs do not overlap: their number is bounded by areas.
    """
    radii, count = world.robots[:, p.RADIUS], len(world.robots)
    around = (2.0 * radii.max() + 2.0 * world.reach + radii.min()) / radii.min()
    pairs = count * min(count - 1, math.ceil(around * around)) // 2
    return int(pairs + count * len(world.walls) + 1)


def scratch(world: WorldArrays) -> Scratch:
    """Allocate the memory in which one world's ticks are worked out."""
    return scratch_for(len(world.robots), contact_capacity(world), WIDTH)

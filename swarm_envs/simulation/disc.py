"""The contact law for discs in a polygon, compiled: speculative contacts solved by sequential impulses.

A robot wishes a velocity; contact changes the wishes as little as possible in the mass metric. A pair may close its gap within the
tick and no more, so a full tick of 0.1 s needs no substeps: with v_n the relative velocity along the normal, v_n >= -gap / dt.
Discs and straight walls only get farther apart than the linearised gap says, whatever the normal, so a solved tick does not overlap.
A tick is solved twice: first to see where it leads, then with the normals and headings of its middle, which makes sliding and
turning contacts accurate to second order.
Friction is Coulomb's on the velocity of the contact points, spins included, bounded by the normal impulse.

A tick costs what happens in it: a robot with nothing near drives its arc; one with a single wall near is solved in closed form, since
nobody else is concerned; the others, the crowd, are solved together.
"""

from __future__ import annotations

import math

import numpy as np

from swarm_envs.compiled import compiled
from swarm_envs.simulation import parameters as p
from swarm_envs.simulation import scratch as m
from swarm_envs.simulation.actuation import drive_ideally, drive_robot
from swarm_envs.simulation.grid import bins, bounds
from swarm_envs.simulation.parameters import Asked, FloatArray, WorldArrays
from swarm_envs.simulation.scratch import IntArray, Scratch, scratch_for
from swarm_envs.simulation.state import StateArrays
from swarm_envs.simulation.touching import LARGE
from swarm_envs.simulation.trigonometry import cos_sin, cos_sin_small

MAX_ITERATIONS = 200
"""Most passes over the contacts in one tick."""
OVER, OVER_PASSES = 1.25, 10
"""Share of what a contact lacks that passes after the first give, up to so many: contacts that lean on each other settle in fewer. Piles
of great friction would never settle so."""
TOLERANCE = 1e-4
"""Passes end when none changed a closing distance by more than this many metres."""
LATTICE = p.MICRO_STEPS
"""A tick is divided only on this lattice."""
TOUCHING = 1e-6
"""A gap in m that counts as closed already: no part of a tick begins with its closing."""

# Columns of a contact.
(
    NORMAL_X,
    NORMAL_Y,
    GAP,
    FRICTION,
    RESTITUTION,
    PUSH,
    DRAG,
    TARGET,
    MASS_ALONG,  # kg that an impulse along the normal moves
    MASS_ACROSS,  # kg that an impulse across it moves, spins included
    FIRST_LIGHT,  # 1 / kg of the first robot
    FIRST_SPIN,  # rad/s of the first robot for an impulse across
    FIRST_RADIUS,
    SECOND_LIGHT,  # these three are 0 for walls
    SECOND_SPIN,
    SECOND_RADIUS,
) = range(16)
WIDTH = 16

# How a robot is solved, in Scratch.place: values from 0 are the only contact's index.
FREE, CROWD = -1, -2
NOWHERE = 1e9
"""Gap in m of a wall that a robot has left behind within a tick."""


@compiled(inline="always", _nrt=False)
def advance(world: WorldArrays, state: StateArrays, w: int, scratch: Scratch, effects: Asked, grid: Asked) -> None:
    """Move the robots of world ``w`` through one tick with contact; ``poses`` of the state change."""
    poses = state.poses[w]
    count = find_contacts(world, poses, scratch, grid)
    if effects is None or world.ideal_drive:
        drive_ideally(world, state, w, scratch)
    if count > 0:
        advance_touching(world, state, w, scratch, count, effects)
    else:
        for i in range(poses.shape[0]):
            move_freely(world, state, w, i, scratch, effects)


@compiled(forceinline=True, _nrt=False)
def move_freely(world: WorldArrays, state: StateArrays, w: int, i: int, scratch: Scratch, effects: Asked) -> None:
    """Move one robot through a tick without contact."""
    wish = scratch.free
    if effects is not None and not world.ideal_drive:
        drive_robot(world, state, w, i, 0.0, 1.0, wish, effects)
    for k in range(3):
        state.poses[w, i, k] += wish[i, k] * world.tick


@compiled(forceinline=True, _nrt=False)
def drive_part(world: WorldArrays, state: StateArrays, w: int, i: int, at: int, until: int, scratch: Scratch, effects: Asked) -> None:
    """Write into ``scratch.free`` with which velocity robot ``i`` would cover a part of the tick without contact."""
    # the whole tick of an ideal drive is there already
    if until - at < LATTICE or (effects is not None and not world.ideal_drive):
        drive_robot(world, state, w, i, at / LATTICE, until / LATTICE, scratch.free, effects)


@compiled(forceinline=True, _nrt=False)
def foreseen(world: WorldArrays, state: StateArrays, w: int, i: int, scratch: Scratch, effects: Asked) -> tuple[float, float]:
    """Velocity with which robot ``i`` sets out on a tick: an ideal drive's mean one, else where it is heading as fast as it goes."""
    if effects is None or world.ideal_drive:
        return scratch.free[i, 0], scratch.free[i, 1]
    c, s = cos_sin(state.poses[w, i, 2])
    return state.motion[w, i, 0] * c, state.motion[w, i, 0] * s


@compiled(_nrt=False)
def advance_touching(world: WorldArrays, state: StateArrays, w: int, scratch: Scratch, count: int, effects: Asked) -> None:
    """Move the robots of world ``w`` through one tick in which ``count`` contacts could close."""
    place, partners = scratch.place, scratch.partners
    robots = place.shape[0]
    for i in range(robots):
        place[i] = FREE
    for k in range(count):
        i, j = partners[k, 0], partners[k, 1]
        if j < robots:
            place[i] = place[j] = CROWD
        else:
            place[i] = k if place[i] == FREE else CROWD
    crowd = False
    for i in range(robots):
        if place[i] == FREE:
            move_freely(world, state, w, i, scratch, effects)
        elif place[i] == CROWD:
            crowd = True
        else:
            slide(world, state, w, i, scratch, effects)
    if crowd:
        kept = int(np.int64(0))  # a plain 0 is another type, for which callees would be compiled, too
        for k in range(count):
            if place[partners[k, 0]] == CROWD:
                if kept != k:
                    for c in range(WIDTH):
                        scratch.contacts[kept, c] = scratch.contacts[k, c]
                    for c in range(3):
                        partners[kept, c] = partners[k, c]
                kept += 1
        advance_crowd(world, state, w, scratch, kept, effects)


@compiled(forceinline=True, _nrt=False)
def slide(world: WorldArrays, state: StateArrays, w: int, i: int, scratch: Scratch, effects: Asked) -> None:
    """Move a robot with one wall near through a tick, in two parts where it first touches within it.

    A normal impulse does not change how fast the contact point slides, nor a tangential one how fast the gap closes:
    one after the other they are the solution.
    """
    wish = scratch.free
    contact = scratch.contacts[scratch.place[i]]
    nx, ny, gap = contact[NORMAL_X], contact[NORMAL_Y], contact[GAP]
    at = int(np.int64(0))  # a plain 0 is another type, for which callees would be compiled, too
    while at < LATTICE:
        until = LATTICE
        if at == 0 and gap > TOUCHING:
            vx, vy = foreseen(world, state, w, i, scratch, effects)
            closing = vx * nx + vy * ny
            if closing * world.tick > gap:
                first = int(gap / closing / world.tick * LATTICE)
                until = first if first > 0 else LATTICE
        drive_part(world, state, w, i, at, until, scratch, effects)
        duration = (until - at) * world.tick / LATTICE
        vx, vy, omega = wish[i, 0], wish[i, 1], wish[i, 2]
        closing = vx * nx + vy * ny
        allowed = gap / duration
        if closing > allowed:
            slid = slide_along(contact, nx, ny, vx, vy, omega, allowed)
            c, s = cos_sin_small(0.5 * duration * (slid[2] - omega))
            vx, vy = c * vx - s * vy, s * vx + c * vy
            closing = vx * nx + vy * ny
            if closing > allowed:
                vx, vy, omega = slide_along(contact, nx, ny, vx, vy, omega, allowed)
        state.poses[w, i, 0] += vx * duration
        state.poses[w, i, 1] += vy * duration
        state.poses[w, i, 2] += omega * duration
        gap -= (vx * nx + vy * ny) * duration
        at = until


@compiled(forceinline=True, _nrt=False)
def slide_along(
    contact: FloatArray, nx: float, ny: float, vx: float, vy: float, omega: float, allowed: float
) -> tuple[float, float, float]:
    """Return the velocity nearest to (vx, vy, omega) that closes the gap of a wall, along (nx, ny), no faster than ``allowed``."""
    closing = vx * nx + vy * ny
    allowed = min(allowed, -contact[RESTITUTION] * closing) if contact[RESTITUTION] > 0.0 else allowed
    push = (closing - allowed) * contact[MASS_ALONG]
    slip = vy * nx - vx * ny + contact[FIRST_RADIUS] * omega
    bound = contact[FRICTION] * push
    drag = min(max(slip * contact[MASS_ACROSS], -bound), bound)
    light = contact[FIRST_LIGHT]
    return vx - light * (nx * push - ny * drag), vy - light * (ny * push + nx * drag), omega - contact[FIRST_SPIN] * drag


@compiled(forceinline=True, _nrt=False)
def advance_crowd(world: WorldArrays, state: StateArrays, w: int, scratch: Scratch, count: int, effects: Asked) -> None:
    """Move the robots of the crowd through one tick, in two parts where some first touch within it."""
    poses, place, velocity, free = state.poses[w], scratch.place, scratch.velocity, scratch.free
    robots = place.shape[0]
    at = int(np.int64(0))  # a plain 0 is another type, for which callees would be compiled, too
    while at < LATTICE:
        until = LATTICE
        if at > 0:
            for k in range(count):
                renew(world, poses, scratch, k)
        elif robots <= LARGE:
            until = first_touch(world, state, w, scratch, count, effects)
        duration = (until - at) * world.tick / LATTICE
        for i in range(robots):
            if place[i] == CROWD:
                drive_part(world, state, w, i, at, until, scratch, effects)
                for k in range(3):
                    velocity[i, k] = free[i, k]
        if solve(duration, scratch, count, 5.0 * TOLERANCE):
            to_middle(poses, duration, scratch, count)
            for i in range(robots):
                for k in range(3):
                    velocity[i, k] = free[i, k]
            solve(duration, scratch, count, TOLERANCE)
        for i in range(robots):
            if place[i] == CROWD:
                for k in range(3):
                    poses[i, k] += velocity[i, k] * duration
        at = until


@compiled(forceinline=True, _nrt=False)
def first_touch(world: WorldArrays, state: StateArrays, w: int, scratch: Scratch, count: int, effects: Asked) -> int:
    """Return the point of the tick's lattice at or before which contacts that are apart first touch, else the tick's end.

    Robots are taken to drive straight on; a touch before the lattice's first point divides nothing.
    """
    poses, velocity = state.poses[w], scratch.velocity
    robots = poses.shape[0]
    for i in range(robots):
        if scratch.place[i] == CROWD:
            velocity[i, 0], velocity[i, 1] = foreseen(world, state, w, i, scratch, effects)
    soonest = world.tick
    for k in range(count):
        i, j = scratch.partners[k, 0], scratch.partners[k, 1]
        contact = scratch.contacts[k]
        gap = contact[GAP]
        if gap <= TOUCHING:
            continue
        vx, vy = velocity[j, 0] - velocity[i, 0], velocity[j, 1] - velocity[i, 1]
        closing = -(vx * contact[NORMAL_X] + vy * contact[NORMAL_Y])
        if closing <= 0.0:
            continue
        if j == robots:
            soonest = min(soonest, gap / closing)
        else:
            touch = contact[FIRST_RADIUS] + contact[SECOND_RADIUS]
            approach, squared = closing * (gap + touch), vx * vx + vy * vy
            inside = approach * approach - squared * gap * (gap + 2.0 * touch)
            if inside > 0.0:
                soonest = min(soonest, (approach - math.sqrt(inside)) / squared)
    first = int(soonest / world.tick * LATTICE)
    return first if first > 0 else LATTICE


@compiled(forceinline=True, _nrt=False)
def to_middle(poses: FloatArray, duration: float, scratch: Scratch, count: int) -> None:
    """Turn wishes and normals to the middle of the motion of ``duration`` s that the first solution leads through."""
    half, free, solved, contacts = 0.5 * duration, scratch.free, scratch.velocity, scratch.contacts
    robots = free.shape[0]
    for i in range(robots):
        turned = (solved[i, 2] - free[i, 2]) * half
        if scratch.place[i] == CROWD and turned != 0.0:
            c, s = cos_sin_small(turned)
            free[i, 0], free[i, 1] = c * free[i, 0] - s * free[i, 1], s * free[i, 0] + c * free[i, 1]
    for k in range(count):
        i, j = scratch.partners[k, 0], scratch.partners[k, 1]
        if j == robots or contacts[k, PUSH] == 0.0:
            continue
        dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
        mx, my = dx + (solved[j, 0] - solved[i, 0]) * half, dy + (solved[j, 1] - solved[i, 1]) * half
        length = math.sqrt(mx * mx + my * my)
        if length > 1e-9:
            contacts[k, NORMAL_X], contacts[k, NORMAL_Y] = mx / length, my / length
            # the gap along the new normal: what the new normal sees of the distance, less the two radii
            contacts[k, GAP] = (dx * mx + dy * my) / length - contacts[k, FIRST_RADIUS] - contacts[k, SECOND_RADIUS]


@compiled(forceinline=True, _nrt=False)
def find_contacts(world: WorldArrays, poses: FloatArray, scratch: Scratch, grid: Asked) -> int:
    """Write every contact that could close within a tick; return their number."""
    robots, walls, columns = world.robots, world.walls, scratch.columns
    count = poses.shape[0]
    for i in range(count):
        columns[m.X, i], columns[m.Y, i] = poses[i, 0], poses[i, 1]
        columns[m.NEAR, i] = robots[i, p.RADIUS] + world.reach
    found = int(np.int64(0))
    if grid is not None:
        found = find_pairs_with_grid(world, poses, scratch)
    else:
        for i in range(1, count):
            x, y, near = columns[m.X, i], columns[m.Y, i], columns[m.NEAR, i]
            # few are near: one look at all without a branch, then one by one
            close = 0
            for j in range(count):
                dx, dy, both = columns[m.X, j] - x, columns[m.Y, j] - y, columns[m.NEAR, j] + near
                close += dx * dx + dy * dy < both * both
            if close > 1:
                for j in range(i):
                    found = add_pair(world, poses, i, j, scratch, found)
    for e in range(walls.shape[0]):
        x, y, ux, uy = walls[e, p.START_X], walls[e, p.START_Y], walls[e, p.ALONG_X], walls[e, p.ALONG_Y]
        close = 0
        for i in range(count):
            # the wall's free side is to its left: positive distances from its line
            close += abs(ux * (columns[m.Y, i] - y) - uy * (columns[m.X, i] - x)) < columns[m.NEAR, i]
        if close > 0:
            for i in range(count):
                if abs(ux * (columns[m.Y, i] - y) - uy * (columns[m.X, i] - x)) < columns[m.NEAR, i]:
                    found = add_wall(world, poses, i, e, scratch, found)
    return found


@compiled(forceinline=True, _nrt=False)
def add_pair(world: WorldArrays, poses: FloatArray, i: int, j: int, scratch: Scratch, found: int) -> int:
    """Append the contact of robots ``i`` and ``j`` if they are near; return the number of contacts."""
    dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
    near = world.robots[i, p.RADIUS] + world.robots[j, p.RADIUS] + 2.0 * world.reach
    if dx * dx + dy * dy >= near * near or found >= scratch.contacts.shape[0]:
        return found
    contact, first, second = scratch.contacts[found], world.robots[i], world.robots[j]
    distance = math.sqrt(dx * dx + dy * dy)
    scratch.partners[found, 0], scratch.partners[found, 1] = i, j
    # two centres in one place have no normal: any will do to part them
    contact[NORMAL_X] = dx / distance if distance > 1e-12 else 1.0
    contact[NORMAL_Y] = dy / distance if distance > 1e-12 else 0.0
    contact[GAP] = distance - first[p.RADIUS] - second[p.RADIUS]
    contact[FRICTION], contact[RESTITUTION] = world.contact[p.ROBOT_FRICTION], world.contact[p.ROBOT_RESTITUTION]
    contact[PUSH] = contact[DRAG] = 0.0
    contact[FIRST_LIGHT], contact[FIRST_SPIN], contact[FIRST_RADIUS] = first[p.INVERSE_MASS], first[p.SPIN], first[p.RADIUS]
    contact[SECOND_LIGHT], contact[SECOND_SPIN], contact[SECOND_RADIUS] = second[p.INVERSE_MASS], second[p.SPIN], second[p.RADIUS]
    light = contact[FIRST_LIGHT] + contact[SECOND_LIGHT]
    contact[MASS_ALONG] = 1.0 / light
    contact[MASS_ACROSS] = 1.0 / (light + contact[FIRST_RADIUS] * contact[FIRST_SPIN] + contact[SECOND_RADIUS] * contact[SECOND_SPIN])
    return found + 1


@compiled(forceinline=True, _nrt=False)
def add_wall(world: WorldArrays, poses: FloatArray, i: int, e: int, scratch: Scratch, found: int) -> int:
    """Append the contact of robot ``i`` with wall ``e`` if it is near; return the number of contacts."""
    if found >= scratch.contacts.shape[0]:
        return found
    nx, ny, gap = wall_seen(world, poses, i, e)
    if gap == NOWHERE:
        return found
    contact, robot = scratch.contacts[found], world.robots[i]
    scratch.partners[found, 0], scratch.partners[found, 1], scratch.partners[found, 2] = i, poses.shape[0], e
    contact[NORMAL_X], contact[NORMAL_Y], contact[GAP] = nx, ny, gap
    contact[FRICTION], contact[RESTITUTION] = world.contact[p.WALL_FRICTION], world.contact[p.WALL_RESTITUTION]
    contact[PUSH] = contact[DRAG] = 0.0
    contact[FIRST_LIGHT], contact[FIRST_SPIN], contact[FIRST_RADIUS] = robot[p.INVERSE_MASS], robot[p.SPIN], robot[p.RADIUS]
    contact[SECOND_LIGHT] = contact[SECOND_SPIN] = contact[SECOND_RADIUS] = 0.0
    contact[MASS_ALONG], contact[MASS_ACROSS] = robot[p.MASS], robot[p.RIM_MASS]
    return found + 1


@compiled(forceinline=True, _nrt=False)
def wall_seen(world: WorldArrays, poses: FloatArray, i: int, e: int) -> tuple[float, float, float]:
    """Return the direction from robot ``i`` to wall ``e`` and the gap in m, ``NOWHERE`` if the wall is of no concern."""
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
            return nx, ny, NOWHERE
        nx, ny, distance = -cx / across, -cy / across, across
    if distance < -radius:
        return nx, ny, NOWHERE
    return nx, ny, distance - radius


@compiled(forceinline=True, _nrt=False)
def renew(world: WorldArrays, poses: FloatArray, scratch: Scratch, k: int) -> None:
    """Measure contact ``k`` anew where its robots are by now."""
    i, j, contact = scratch.partners[k, 0], scratch.partners[k, 1], scratch.contacts[k]
    contact[PUSH] = contact[DRAG] = 0.0
    if j == poses.shape[0]:
        contact[NORMAL_X], contact[NORMAL_Y], contact[GAP] = wall_seen(world, poses, i, scratch.partners[k, 2])
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
        widest = max(widest, scratch.columns[m.NEAR, i])
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
                    found = add_pair(world, poses, i, order[k], scratch, found)
    return found


@compiled(_nrt=False)
def solve(duration: float, scratch: Scratch, count: int, tolerance: float) -> bool:
    """Change the crowd's velocities so that no contact closes more than its gap, with friction and restitution.

    Args:
        duration: Of the motion in s.
        scratch: Velocities without contact, changed; contacts, whose impulses are applied first, so that a second solution starts
            from the first.
        count: Number of contacts.
        tolerance: Passes end when none changed a closing distance by more than this many m.

    Returns:
        Whether any contact had to push.
    """
    velocity, contacts, partners, moved = scratch.velocity, scratch.contacts, scratch.partners, scratch.moved
    wall = moved.shape[0] - 1
    pushes = False
    for k in range(count):
        opening = opening_speed(velocity, contacts, partners, k)
        contacts[k, TARGET] = -contacts[k, GAP] / duration
        if opening < contacts[k, TARGET]:
            pushes = True
            if contacts[k, RESTITUTION] > 0.0:
                contacts[k, TARGET] = max(contacts[k, TARGET], -contacts[k, RESTITUTION] * opening)
        pushes = pushes or contacts[k, PUSH] > 0.0
    if not pushes:
        return False
    for k in range(count):
        if contacts[k, PUSH] > 0.0:
            push(velocity, contacts, partners, k, contacts[k, PUSH], contacts[k, DRAG])
    # in a large swarm piles settle one after the other; in a small one looking who has settled costs more than it saves
    many = moved.shape[0] > LARGE
    if many:
        for i in range(moved.shape[0]):
            moved[i] = 0
    for number in range(1, MAX_ITERATIONS + 1):
        share = OVER if 1 < number < OVER_PASSES else 1.0
        change = 0.0
        for k in range(count):
            i, j = partners[k, 0], partners[k, 1]
            if many and moved[i] < number - 1 and moved[j] < number - 1:
                continue  # nobody has pushed either since they were last looked at
            before = contacts[k, PUSH]
            nx, ny, light, other_light = contacts[k, NORMAL_X], contacts[k, NORMAL_Y], contacts[k, FIRST_LIGHT], contacts[k, SECOND_LIGHT]
            # read once: the compiler cannot know that what is written below is not what is read again
            ix, iy, spin = velocity[i, 0], velocity[i, 1], velocity[i, 2]
            jx, jy, other_spin = velocity[j, 0], velocity[j, 1], velocity[j, 2]
            vx, vy = jx - ix, jy - iy
            pushed = max(0.0, before + share * (contacts[k, TARGET] - (vx * nx + vy * ny)) * contacts[k, MASS_ALONG])
            if pushed == 0.0 and before == 0.0:
                continue
            dragged, bound = contacts[k, DRAG], contacts[k, FRICTION] * pushed
            slip = vy * nx - vx * ny - contacts[k, FIRST_RADIUS] * spin - contacts[k, SECOND_RADIUS] * other_spin
            drag = min(max(dragged - share * slip * contacts[k, MASS_ACROSS], -bound), bound)
            along, across = pushed - before, drag - dragged
            contacts[k, PUSH], contacts[k, DRAG] = pushed, drag
            x, y = nx * along - ny * across, ny * along + nx * across
            velocity[i, 0], velocity[i, 1] = ix - light * x, iy - light * y
            velocity[i, 2] = spin - contacts[k, FIRST_SPIN] * across
            velocity[j, 0], velocity[j, 1] = jx + other_light * x, jy + other_light * y
            velocity[j, 2] = other_spin - contacts[k, SECOND_SPIN] * across
            lightness = light + other_light
            spinning = contacts[k, FIRST_RADIUS] * contacts[k, FIRST_SPIN] + contacts[k, SECOND_RADIUS] * contacts[k, SECOND_SPIN]
            by = max(abs(along) * lightness, abs(across) * (lightness + spinning)) * duration
            change = max(change, by)
            if many and by >= tolerance:
                moved[i] = number
                if j != wall:
                    moved[j] = number
        if change < tolerance:
            break
    return True


@compiled(forceinline=True, _nrt=False)
def opening_speed(velocity: FloatArray, contacts: FloatArray, partners: IntArray, k: int) -> float:
    """Velocity in m/s with which contact ``k`` opens."""
    i, j = partners[k, 0], partners[k, 1]
    vx, vy = velocity[j, 0] - velocity[i, 0], velocity[j, 1] - velocity[i, 1]
    return float(vx * contacts[k, NORMAL_X] + vy * contacts[k, NORMAL_Y])


@compiled(forceinline=True, _nrt=False)
def push(velocity: FloatArray, contacts: FloatArray, partners: IntArray, k: int, along: float, across: float) -> None:
    """Apply impulses in kg m/s along the normal of contact ``k``, and counter-clockwise from it."""
    i, j = partners[k, 0], partners[k, 1]
    nx, ny = contacts[k, NORMAL_X], contacts[k, NORMAL_Y]
    x, y = nx * along - ny * across, ny * along + nx * across
    velocity[i, 0] -= contacts[k, FIRST_LIGHT] * x
    velocity[i, 1] -= contacts[k, FIRST_LIGHT] * y
    velocity[i, 2] -= contacts[k, FIRST_SPIN] * across
    velocity[j, 0] += contacts[k, SECOND_LIGHT] * x
    velocity[j, 1] += contacts[k, SECOND_LIGHT] * y
    velocity[j, 2] -= contacts[k, SECOND_SPIN] * across


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

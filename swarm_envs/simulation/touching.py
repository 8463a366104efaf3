"""Who touches whom: for pictures, metrics, stalled wheels, and for skipping substeps when nothing is near."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from swarm_envs.compiled import compiled
from swarm_envs.simulation import parameters as p
from swarm_envs.simulation.parameters import FloatArray, WorldArrays
from swarm_envs.simulation.state import StateArrays

TOUCH = 1e-3
"""A gap in m below which two surfaces count as touching."""
TOUCHES_ROBOT, TOUCHES_WALL = 1, 2
REACH_OUT = 1e-4
"""What a robot's disc is larger in m for Chipmunk: robots that slide round each other still touch in the middle of a substep, where the
chord of their way opens a gap of up to 0.1 mm. Touches are foreseen at half of this depth, so that no contact begins on its edge."""
UNSOLVED = 0.005
"""Robots that touch and approach each other at more m/s than this, as contact made them move last, were not solved together yet."""
LARGE = 40
"""Swarms above this are taken to have something near at all times."""

# Columns of how a robot moves: as it wishes and as contact made it, in m/s; whether contact changed its way; by how much its turn, rad/s;
# the speed and turn rate that it set out with when contact was last solved.
WISH_X, WISH_Y, HELD_X, HELD_Y, HELD, TURNED, SET_SPEED, SET_TURN = range(8)


@compiled(forceinline=True, _nrt=False)
def pair_within(world: WorldArrays, poses: FloatArray, i: int, j: int, margin: float) -> bool:
    """Whether the gap between two robots is below ``margin`` m."""
    dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
    near = world.robots[i, p.RADIUS] + world.robots[j, p.RADIUS] + margin
    return bool(dx * dx + dy * dy < near * near)


@compiled(forceinline=True, _nrt=False)
def wall_within(world: WorldArrays, poses: FloatArray, i: int, e: int, margin: float) -> bool:
    """Whether the gap between a robot and a wall is below ``margin`` m."""
    walls = world.walls
    near = world.robots[i, p.RADIUS] + margin
    px, py = poses[i, 0] - walls[e, p.START_X], poses[i, 1] - walls[e, p.START_Y]
    ux, uy = walls[e, p.ALONG_X], walls[e, p.ALONG_Y]
    across = ux * py - uy * px
    if across > near or across < -near:
        return False
    along = px * ux + py * uy
    over = along - min(max(along, 0.0), walls[e, p.LENGTH])
    return bool(across * across + over * over < near * near)


@compiled(forceinline=True, _nrt=False)
def beyond_end(world: WorldArrays, poses: FloatArray, i: int, e: int) -> bool:
    """Whether a robot's centre lies past an end of a wall, so that it could only touch that end."""
    walls = world.walls
    along = (poses[i, 0] - walls[e, p.START_X]) * walls[e, p.ALONG_X] + (poses[i, 1] - walls[e, p.START_Y]) * walls[e, p.ALONG_Y]
    return bool(along < 0.0 or along > walls[e, p.LENGTH])


@compiled(forceinline=True, _nrt=False)
def time_to_touch(world: WorldArrays, poses: FloatArray, motion: FloatArray) -> float:
    """Return the time in s until two robots, or a robot and a wall, that are apart could touch; infinite if none could.

    It is 0 where two touch that contact has not held up yet: the next substep is the shortest there is and tells how it will.
    Robots drive straight on, each as it wishes or as contact made it, whichever brings the two together faster.

    Args:
        world: Parameters.
        poses: (R, 3).
        motion: (R, 8) columns above.
    """
    count = poses.shape[0]
    soonest = math.inf
    for i in range(count):
        for j in range(i):
            dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
            a = WISH_X if dx * (motion[i, WISH_X] - motion[i, HELD_X]) + dy * (motion[i, WISH_Y] - motion[i, HELD_Y]) > 0.0 else HELD_X
            b = WISH_X if dx * (motion[j, WISH_X] - motion[j, HELD_X]) + dy * (motion[j, WISH_Y] - motion[j, HELD_Y]) < 0.0 else HELD_X
            vx, vy = motion[j, b] - motion[i, a], motion[j, b + 1] - motion[i, a + 1]
            touch = world.robots[i, p.RADIUS] + world.robots[j, p.RADIUS] + REACH_OUT
            outside, approach = dx * dx + dy * dy - touch * touch, dx * vx + dy * vy
            inside = approach * approach - (vx * vx + vy * vy) * outside
            if approach >= 0.0:
                continue
            if outside > 2.0 * REACH_OUT * touch:
                if inside > 0.0:
                    # the root of a quadratic in the form that nothing cancels or underflows in: solved velocities fade to 1e-160 m/s
                    soonest = min(soonest, outside / (math.sqrt(inside) - approach))
            elif dx * (motion[j, HELD_X] - motion[i, HELD_X]) + dy * (motion[j, HELD_Y] - motion[i, HELD_Y]) < -UNSOLVED * touch:
                return 0.0
        for e in range(world.walls.shape[0]):
            ux, uy = world.walls[e, p.ALONG_X], world.walls[e, p.ALONG_Y]
            px, py = poses[i, 0] - world.walls[e, p.START_X], poses[i, 1] - world.walls[e, p.START_Y]
            gap = ux * py - uy * px - world.robots[i, p.RADIUS] - 0.5 * REACH_OUT
            held = ux * motion[i, HELD_Y] - uy * motion[i, HELD_X]
            opening = min(ux * motion[i, WISH_Y] - uy * motion[i, WISH_X], held)
            if opening >= 0.0:
                continue
            if gap > 0.5 * REACH_OUT:
                soonest = min(soonest, gap / -opening)
            elif gap > -world.robots[i, p.RADIUS] and held < -UNSOLVED:
                along = px * ux + py * uy
                if 0.0 <= along <= world.walls[e, p.LENGTH]:
                    return 0.0
    return soonest


@compiled(forceinline=True, _nrt=False)
def still_touch(world: WorldArrays, poses: FloatArray, motion: FloatArray, ahead: float) -> bool:
    """Whether all that touch will be within :data:`REACH_OUT` after ``ahead`` s if they go on as contact made them move."""
    for i in range(poses.shape[0]):
        x, y = poses[i, 0] + ahead * motion[i, HELD_X], poses[i, 1] + ahead * motion[i, HELD_Y]
        for j in range(i):
            touch = world.robots[i, p.RADIUS] + world.robots[j, p.RADIUS] + 2.0 * REACH_OUT
            dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
            if dx * dx + dy * dy > touch * touch:
                continue
            dx, dy = poses[j, 0] + ahead * motion[j, HELD_X] - x, poses[j, 1] + ahead * motion[j, HELD_Y] - y
            if dx * dx + dy * dy > touch * touch:
                return False
        for e in range(world.walls.shape[0]):
            wall, radius = world.walls[e], world.robots[i, p.RADIUS]
            ux, uy = wall[p.ALONG_X], wall[p.ALONG_Y]
            gap = ux * (poses[i, 1] - wall[p.START_Y]) - uy * (poses[i, 0] - wall[p.START_X]) - radius
            if -radius < gap < REACH_OUT and gap + ahead * (ux * motion[i, HELD_Y] - uy * motion[i, HELD_X]) > REACH_OUT:
                return False
    return True


@compiled()
def touching(world: WorldArrays, poses: FloatArray) -> npt.NDArray[np.uint8]:
    """Return for each robot (R,) whether it touches a robot (bit 0) and a wall (bit 1)."""
    count = poses.shape[0]
    flags = np.zeros(count, np.uint8)
    for i in range(count):
        for j in range(i):
            if pair_within(world, poses, i, j, TOUCH):
                flags[i] |= TOUCHES_ROBOT
                flags[j] |= TOUCHES_ROBOT
        for e in range(world.walls.shape[0]):
            if wall_within(world, poses, i, e, TOUCH):
                flags[i] |= TOUCHES_WALL
    return flags


@compiled(_nrt=False)
def stall_wheels(world: WorldArrays, state: StateArrays, w: int) -> None:
    """Mark the robots of world ``w`` that another robot touches on a wheel: a bare body's servos stall (paper, Bump Shield)."""
    poses = state.poses[w]
    for i in range(poses.shape[0]):
        state.stalled[w, i] = 0
        half_angle = world.robots[i, p.STALL_HALF_ANGLE]
        if half_angle == 0.0:
            continue
        for j in range(poses.shape[0]):
            if j != i and pair_within(world, poses, i, j, TOUCH):
                bearing = math.atan2(poses[j, 1] - poses[i, 1], poses[j, 0] - poses[i, 0]) - poses[i, 2]
                # the axle lies across the heading: a touch near +-90 degrees is on a wheel
                if abs(math.cos(bearing)) < math.sin(half_angle):
                    state.stalled[w, i] = 1

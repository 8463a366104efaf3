"""Who touches whom: for pictures, metrics, stalled wheels, and for skipping substeps when nothing is near."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from swarm_envs.compiled import compiled
from swarm_envs.simulation import parameters as p
from swarm_envs.simulation.parameters import FloatArray, WorldArrays
from swarm_envs.simulation.state import StateArrays

TOUCHING_GAP = 1e-3
"""A gap in m below which two surfaces count as touching."""
TOUCHES_ROBOT, TOUCHES_WALL = 1, 2
CONTACT_MARGIN = 1e-4
"""What a robot's disc is larger in m for Chipmunk: robots that slide round each other still touch in the middle of a substep, where the
chord of their way opens a gap of up to 0.1 mm. Touches are predicted at half of this depth, so that no contact begins on its edge."""
UNSOLVED_APPROACH = 0.005
"""Robots that touch and approach each other at more m/s than this, as contact made them move last, were not solved together yet."""
LARGE_SWARM = 40
"""Swarms above this are taken to have something near at all times."""

# Columns of a robot's predicted motion: as desired and as contact solved it, m/s; whether contact blocked it; by how much contact turned
# it, rad/s; the speed and turn rate that it set out with when contact was last solved.
DESIRED_X, DESIRED_Y, SOLVED_X, SOLVED_Y, BLOCKED, TURN_BY_CONTACT, LAST_SPEED, LAST_TURN = range(8)


@compiled(forceinline=True, _nrt=False)
def robots_within(world: WorldArrays, poses: FloatArray, i: int, j: int, margin: float) -> bool:
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
def time_of_impact(world: WorldArrays, poses: FloatArray, predicted: FloatArray) -> float:
    """Return the time in s until two robots, or a robot and a wall, that are apart could touch; infinite if none could.

    It is 0 where two touch that contact has not blocked yet: the next substep is the shortest there is and tells how it will.
    Robots drive straight on, each as desired or as contact made it, whichever brings the two together faster.

    Args:
        world: Parameters.
        poses: (R, 3).
        predicted: (R, 8) columns above.
    """
    count = poses.shape[0]
    earliest = math.inf
    for i in range(count):
        for j in range(i):
            dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
            a = (
                DESIRED_X
                if dx * (predicted[i, DESIRED_X] - predicted[i, SOLVED_X]) + dy * (predicted[i, DESIRED_Y] - predicted[i, SOLVED_Y]) > 0.0
                else SOLVED_X
            )
            b = (
                DESIRED_X
                if dx * (predicted[j, DESIRED_X] - predicted[j, SOLVED_X]) + dy * (predicted[j, DESIRED_Y] - predicted[j, SOLVED_Y]) < 0.0
                else SOLVED_X
            )
            vx, vy = predicted[j, b] - predicted[i, a], predicted[j, b + 1] - predicted[i, a + 1]
            touch = world.robots[i, p.RADIUS] + world.robots[j, p.RADIUS] + CONTACT_MARGIN
            outside, approach = dx * dx + dy * dy - touch * touch, dx * vx + dy * vy
            inside = approach * approach - (vx * vx + vy * vy) * outside
            if approach >= 0.0:
                continue
            if outside > 2.0 * CONTACT_MARGIN * touch:
                if inside > 0.0:
                    # the root of a quadratic in the form that nothing cancels or underflows in: solved velocities fade to 1e-160 m/s
                    earliest = min(earliest, outside / (math.sqrt(inside) - approach))
            elif (
                dx * (predicted[j, SOLVED_X] - predicted[i, SOLVED_X]) + dy * (predicted[j, SOLVED_Y] - predicted[i, SOLVED_Y])
                < -UNSOLVED_APPROACH * touch
            ):
                return 0.0
        for e in range(world.walls.shape[0]):
            ux, uy = world.walls[e, p.ALONG_X], world.walls[e, p.ALONG_Y]
            px, py = poses[i, 0] - world.walls[e, p.START_X], poses[i, 1] - world.walls[e, p.START_Y]
            gap = ux * py - uy * px - world.robots[i, p.RADIUS] - 0.5 * CONTACT_MARGIN
            solved = ux * predicted[i, SOLVED_Y] - uy * predicted[i, SOLVED_X]
            opening = min(ux * predicted[i, DESIRED_Y] - uy * predicted[i, DESIRED_X], solved)
            if opening >= 0.0:
                continue
            if gap > 0.5 * CONTACT_MARGIN:
                earliest = min(earliest, gap / -opening)
            elif gap > -world.robots[i, p.RADIUS] and solved < -UNSOLVED_APPROACH:
                along = px * ux + py * uy
                if 0.0 <= along <= world.walls[e, p.LENGTH]:
                    return 0.0
    return earliest


@compiled(forceinline=True, _nrt=False)
def contacts_persist(world: WorldArrays, poses: FloatArray, predicted: FloatArray, ahead: float) -> bool:
    """Whether all that touch will be within :data:`REACH_OUT` after ``ahead`` s if they go on as contact made them move."""
    for i in range(poses.shape[0]):
        x, y = poses[i, 0] + ahead * predicted[i, SOLVED_X], poses[i, 1] + ahead * predicted[i, SOLVED_Y]
        for j in range(i):
            touch = world.robots[i, p.RADIUS] + world.robots[j, p.RADIUS] + 2.0 * CONTACT_MARGIN
            dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
            if dx * dx + dy * dy > touch * touch:
                continue
            dx, dy = poses[j, 0] + ahead * predicted[j, SOLVED_X] - x, poses[j, 1] + ahead * predicted[j, SOLVED_Y] - y
            if dx * dx + dy * dy > touch * touch:
                return False
        for e in range(world.walls.shape[0]):
            wall, radius = world.walls[e], world.robots[i, p.RADIUS]
            ux, uy = wall[p.ALONG_X], wall[p.ALONG_Y]
            gap = ux * (poses[i, 1] - wall[p.START_Y]) - uy * (poses[i, 0] - wall[p.START_X]) - radius
            if (
                -radius < gap < CONTACT_MARGIN
                and gap + ahead * (ux * predicted[i, SOLVED_Y] - uy * predicted[i, SOLVED_X]) > CONTACT_MARGIN
            ):
                return False
    return True


@compiled()
def touching(world: WorldArrays, poses: FloatArray) -> npt.NDArray[np.uint8]:
    """Return for each robot (R,) whether it touches a robot (bit 0) and a wall (bit 1)."""
    count = poses.shape[0]
    flags = np.zeros(count, np.uint8)
    for i in range(count):
        for j in range(i):
            if robots_within(world, poses, i, j, TOUCHING_GAP):
                flags[i] |= TOUCHES_ROBOT
                flags[j] |= TOUCHES_ROBOT
        for e in range(world.walls.shape[0]):
            if wall_within(world, poses, i, e, TOUCHING_GAP):
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
            if j != i and robots_within(world, poses, i, j, TOUCHING_GAP):
                bearing = math.atan2(poses[j, 1] - poses[i, 1], poses[j, 0] - poses[i, 0]) - poses[i, 2]
                # the axle lies across the heading: a touch near +-90 degrees is on a wheel
                if abs(math.cos(bearing)) < math.sin(half_angle):
                    state.stalled[w, i] = 1

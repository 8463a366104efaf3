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
OPEN = 1e-9
"""A gap in m above minus this counts as open where touches are foreseen: what touches exactly is no contact yet to a solver."""
LARGE = 40
"""Swarms above this are taken to have something near at all times."""

# Columns of how a robot moves: as it wishes and as contact made it, in m/s; whether contact changed its way; by how much its turn, rad/s.
WISH_X, WISH_Y, HELD_X, HELD_Y, HELD, TURNED = range(6)


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

    Robots drive straight on, each as it wishes or as contact made it, whichever brings the two together faster.

    Args:
        world: Parameters.
        poses: (R, 3).
        motion: (R, 6) columns above.
    """
    count = poses.shape[0]
    soonest = math.inf
    for i in range(count):
        for j in range(i):
            dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
            a = WISH_X if dx * (motion[i, WISH_X] - motion[i, HELD_X]) + dy * (motion[i, WISH_Y] - motion[i, HELD_Y]) > 0.0 else HELD_X
            b = WISH_X if dx * (motion[j, WISH_X] - motion[j, HELD_X]) + dy * (motion[j, WISH_Y] - motion[j, HELD_Y]) < 0.0 else HELD_X
            vx, vy = motion[j, b] - motion[i, a], motion[j, b + 1] - motion[i, a + 1]
            touch = world.robots[i, p.RADIUS] + world.robots[j, p.RADIUS]
            outside, approach = dx * dx + dy * dy - touch * touch, dx * vx + dy * vy
            inside = approach * approach - (vx * vx + vy * vy) * outside
            if outside > -OPEN * touch and approach < 0.0 and inside > 0.0:
                # the root of a quadratic in the form that nothing cancels or underflows in: solved velocities fade to 1e-160 m/s
                soonest = min(soonest, max(outside, 0.0) / (math.sqrt(inside) - approach))
        for e in range(world.walls.shape[0]):
            ux, uy = world.walls[e, p.ALONG_X], world.walls[e, p.ALONG_Y]
            px, py = poses[i, 0] - world.walls[e, p.START_X], poses[i, 1] - world.walls[e, p.START_Y]
            gap = ux * py - uy * px - world.robots[i, p.RADIUS]
            opening = min(ux * motion[i, WISH_Y] - uy * motion[i, WISH_X], ux * motion[i, HELD_Y] - uy * motion[i, HELD_X])
            if gap > -OPEN and opening < 0.0:
                soonest = min(soonest, max(gap, 0.0) / -opening)
    return soonest


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

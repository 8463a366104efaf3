"""Who touches whom: robots and walls within a gap of each other; for engines, stalled wheels, pictures and metrics."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from swarm_envs.compiled import compiled
from swarm_envs.simulation import parameters as p
from swarm_envs.simulation.parameters import FloatArray, WorldArrays
from swarm_envs.simulation.segments import offset_from_segment, segment_distance
from swarm_envs.simulation.state import StateArrays

TOUCHING_GAP = 1e-3
"""A gap in m below which two surfaces count as touching."""
ROBOT_CONTACT, WALL_CONTACT = 1, 2
"""Bits of what a robot touches."""


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
    dx, dy = offset_from_segment(px, py, ux, uy, 1.0, walls[e, p.LENGTH])
    return bool(dx * dx + dy * dy < near * near)


@compiled()
def contact_flags(positions: FloatArray, radii: FloatArray, walls: FloatArray, gap: float) -> npt.NDArray[np.uint8]:
    """Return what each robot touches, a sum of :data:`ROBOT_CONTACT` and :data:`WALL_CONTACT`.

    Args:
        positions: (moments, R, 2) in m.
        radii: (R,) contact radii in m.
        walls: (E, 4) segments: x and y of both ends in m.
        gap: Gap in m up to which two surfaces count as touching.

    Returns:
        (moments, R).
    """
    moments, robots = positions.shape[:2]
    flags = np.zeros((moments, robots), dtype=np.uint8)
    for moment in range(moments):
        at, touched = positions[moment], flags[moment]
        for i in range(robots):
            x, y = at[i, 0], at[i, 1]
            for k in range(walls.shape[0]):
                if segment_distance(x, y, walls[k]) <= radii[i] + gap:
                    touched[i] |= WALL_CONTACT
            for j in range(i):
                near = radii[i] + radii[j] + gap
                if (at[j, 0] - x) ** 2 + (at[j, 1] - y) ** 2 <= near * near:
                    touched[i] |= ROBOT_CONTACT
                    touched[j] |= ROBOT_CONTACT
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

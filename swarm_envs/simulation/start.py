"""How a run begins: robots on distinct points of the start grid, headings uniform, everything else at rest."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from swarm_envs.compiled import compiled
from swarm_envs.simulation.parameters import FloatArray, WorldArrays
from swarm_envs.simulation.randomness import STREAM_GAINS, STREAM_START_HEADING, STREAM_START_POINT, normal, uniform
from swarm_envs.simulation.scratch import IntArray
from swarm_envs.simulation.state import StateArrays
from swarm_envs.worlds import WorldError, WorldSpec

OVERLAP_ALLOWED = 5e-3
"""Overlap in m of given start poses that still counts as touching: what an engine may leave, so that any recorded frame is a start."""


def start_worlds(
    world: WorldArrays, state: StateArrays, worlds: IntArray, keys: npt.NDArray[np.uint64], points: FloatArray, objects: FloatArray
) -> None:
    """Put the worlds with these indices at their starts, drawn with ``keys``.

    Args:
        world: Parameters.
        state: State; every entry of those worlds changes.
        worlds: (n,) indices.
        keys: (n,) of the worlds' random draws.
        points: (P, 2) start points in m, at least as many as robots.
        objects: (B, 6) poses and velocities of the objects.
    """
    for array in state:
        array[worlds] = 0
    state.keys[worlds], state.objects[worlds] = keys, objects
    draw_starts(world, state, worlds, points, np.empty(len(points), np.int64))


@compiled(_nrt=False)
def draw_starts(world: WorldArrays, state: StateArrays, worlds: IntArray, points: FloatArray, order: IntArray) -> None:
    """Draw poses and each robot's own gains; ``order`` (P,) is scratch."""
    for w in worlds:
        key = state.keys[w]
        for k in range(points.shape[0]):
            order[k] = k
        for i in range(state.poses.shape[1]):
            # Fisher and Yates: the first robots of a random order of the points
            j = i + int(uniform(key, i, 0, STREAM_START_POINT) * (points.shape[0] - i))
            order[i], order[j] = order[j], order[i]
            state.poses[w, i, 0] = points[order[i], 0]
            state.poses[w, i, 1] = points[order[i], 1]
            state.poses[w, i, 2] = 2.0 * math.pi * uniform(key, i, 0, STREAM_START_HEADING)
            state.gains[w, i, 0] = 1.0 + world.effects[i].linear_gain_spread * normal(key, i, 0, STREAM_GAINS)
            state.gains[w, i, 1] = 1.0 + world.effects[i].angular_gain_spread * normal(key, i, 1, STREAM_GAINS)


def object_starts(world: WorldSpec) -> FloatArray:
    """Return the start (B, 6) of the pushable objects: pose, then velocity zero."""
    starts = np.zeros((len(world.objects), 6))
    for row, item in zip(starts, world.objects, strict=True):
        row[:3] = item.pose
    return starts


def check_start(world: WorldSpec, poses: FloatArray) -> None:
    """Refuse start poses (W, R, 3) that are not finite, lie outside the arena, or overlap.

    Raises:
        WorldError: One line with the world and robot of the batch and the reason.
    """
    import shapely

    from swarm_envs.worlds.geometry import free_floor

    if not np.all(np.isfinite(poses)):
        raise WorldError("initial_poses: holds a value that is not finite; expected x, y in m and heading in rad")
    radii = np.array([robot.body.contact_radius for robot in world.robots])
    for radius in np.unique(radii):
        free = free_floor(world, float(radius) - OVERLAP_ALLOWED)
        shapely.prepare(free)
        inside = shapely.intersects_xy(free, poses[:, radii == radius, 0], poses[:, radii == radius, 1])
        if not inside.all():
            w, k = np.argwhere(~inside)[0]
            i = int(np.flatnonzero(radii == radius)[k])
            x, y = poses[w, i, :2]
            raise WorldError(
                f"initial_poses: robot {i} of world {w} at ({x:.3f}, {y:.3f}) m does not fit in the arena of {world.name!r}; move it"
            )
    for w in range(len(poses)):
        gaps = np.hypot(*(poses[w, :, None, :2] - poses[w, None, :, :2]).transpose(2, 0, 1)) - radii[:, None] - radii[None, :]
        np.fill_diagonal(gaps, np.inf)
        if gaps.min() < -OVERLAP_ALLOWED:
            i, j = divmod(int(gaps.argmin()), len(radii))
            raise WorldError(f"initial_poses: robots {i} and {j} of world {w} overlap by {-1e3 * gaps.min():.1f} mm; move them apart")

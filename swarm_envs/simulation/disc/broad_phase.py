"""Which contacts could close within a tick."""

from __future__ import annotations

import math

import numpy as np

from swarm_envs.compiled import compiled
from swarm_envs.simulation import parameters as p
from swarm_envs.simulation import scratch as m
from swarm_envs.simulation.disc.contact import WIDTH, add_robot_contact, add_wall_contact
from swarm_envs.simulation.grid import bounding_box, cell_list
from swarm_envs.simulation.parameters import FeatureFlag, FloatArray, WorldArrays
from swarm_envs.simulation.scratch import Scratch, scratch_for


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


@compiled()
def find_pairs_with_grid(world: WorldArrays, poses: FloatArray, scratch: Scratch) -> int:
    """Append the near pairs of a large swarm, looking only into neighbouring cells."""
    low_x, low_y, width, height = bounding_box(poses)
    widest = 0.0
    for i in range(poses.shape[0]):
        widest = max(widest, scratch.columns[m.EXTENT, i])
    cell = max(2.0 * widest, 0.5 * math.sqrt((width * height + 1e-6) / poses.shape[0]))
    columns, rows = int(width / cell) + 1, int(height / cell) + 1
    first, order = cell_list(poses, low_x, low_y, cell, columns, rows)
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


def contact_capacity(world: WorldArrays) -> int:
    """A bound on the contacts of one tick.

    A robot's partners have their centres within two radii and two reaches, and discs do not overlap: their number is bounded by areas.
    """
    radii, count = world.robots[:, p.RADIUS], len(world.robots)
    around = (2.0 * radii.max() + 2.0 * world.reach + radii.min()) / radii.min()
    pairs = count * min(count - 1, math.ceil(around * around)) // 2
    return int(pairs + count * len(world.walls) + 1)


def allocate_scratch(world: WorldArrays) -> Scratch:
    """Allocate the memory in which one world's ticks are worked out."""
    return scratch_for(len(world.robots), contact_capacity(world), WIDTH)

"""Large swarms: square cells that keep their neighbour searches from being quadratic."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from swarm_envs.compiled import compiled
from swarm_envs.simulation.parameters import FloatArray

IntArray = npt.NDArray[np.int64]

GRID_FROM = 40
"""With this many robots or more, neighbours are looked for in cells."""
LARGE_SWARM = 40
"""Swarms above this are taken to have something near at all times."""


@compiled(_nrt=False)
def bounding_box(poses: FloatArray) -> tuple[float, float, float, float]:
    """Return the box around robots (R, 3): its lower left corner, width and height in m."""
    left, bottom, right, top = poses[0, 0], poses[0, 1], poses[0, 0], poses[0, 1]
    for i in range(1, poses.shape[0]):
        left, right = min(left, poses[i, 0]), max(right, poses[i, 0])
        bottom, top = min(bottom, poses[i, 1]), max(top, poses[i, 1])
    return left, bottom, right - left, top - bottom


@compiled()
def cell_list(poses: FloatArray, low_x: float, low_y: float, cell: float, columns: int, rows: int) -> tuple[IntArray, IntArray]:
    """Sort robots into square cells; return each cell's first place (cells + 1,) in the order (R,), and the order."""
    first = np.empty(columns * rows + 1, np.int64)
    fill = np.empty(columns * rows, np.int64)
    for k in range(columns * rows + 1):
        first[k] = 0
    where = np.empty(poses.shape[0], np.int64)
    for i in range(poses.shape[0]):
        where[i] = int((poses[i, 1] - low_y) / cell) * columns + int((poses[i, 0] - low_x) / cell)
        first[where[i] + 1] += 1
    for k in range(columns * rows):
        fill[k] = first[k]
        first[k + 1] += first[k]
    order = np.empty(poses.shape[0], np.int64)
    for i in range(poses.shape[0]):
        order[fill[where[i]]] = i
        fill[where[i]] += 1
    return first, order

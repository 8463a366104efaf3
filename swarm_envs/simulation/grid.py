"""Square cells that keep neighbour searches in large swarms from being quadratic."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from swarm_envs.compiled import compiled
from swarm_envs.simulation.parameters import FloatArray

IntArray = npt.NDArray[np.int64]


@compiled()
def bins(poses: FloatArray, low_x: float, low_y: float, cell: float, columns: int, rows: int) -> tuple[IntArray, IntArray]:
    """Sort robots into square cells; return each cell's first place (cells + 1,) in the order (R,), and the order."""
    first = np.zeros(columns * rows + 1, np.int64)
    where = np.empty(poses.shape[0], np.int64)
    for i in range(poses.shape[0]):
        where[i] = int((poses[i, 1] - low_y) / cell) * columns + int((poses[i, 0] - low_x) / cell)
        first[where[i] + 1] += 1
    for k in range(columns * rows):
        first[k + 1] += first[k]
    order = np.empty(poses.shape[0], np.int64)
    fill = first.copy()
    for i in range(poses.shape[0]):
        order[fill[where[i]]] = i
        fill[where[i]] += 1
    return first, order

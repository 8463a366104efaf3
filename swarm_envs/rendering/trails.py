"""Where robots came from: fading paths to lay under the greyscale videos, compiled."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from swarm_envs.compiled import compiled
from swarm_envs.cores import available_cores
from swarm_envs.rendering.greyscale import WORLDS_PER_TASK, Array, Grey, Indices, frame_indices
from swarm_envs.rendering.view import bounds
from swarm_envs.simulation import Trajectories

PATH_GREY = 160
"""Grey of a path where the robot is now; that of the visible disc."""
RELATIVE_WIDTH = 0.5
"""Width of a path over the visible disc's."""


def trails(trajectories: Trajectories, frames: int = 3, size: int = 64, *, threads: int | None = None) -> Grey:
    """Draw the robots' paths between the pictures of :func:`swarm_envs.rendering.videos`.

    The last half of the run falls into ``frames`` equal parts. A picture shows every robot's path through one of them, tick by tick, black
    where the part begins and ever lighter, evenly in time, up to where the robot is at its end: where the video shows it. Where paths
    cross, the lighter one is seen.

    Args:
        trajectories: Poses (worlds, frames, robots, 3) in m, m, rad and their world.
        frames: Pictures per video.
        size: Side of a picture in pixels.
        threads: Threads to draw with, by default one per core; the result does not depend on it.

    Returns:
        (worlds, frames, size, size) uint8, row 0 the top (greatest y).
    """
    world, poses = trajectories.world, trajectories.poses
    ends = frame_indices(poses.shape[1], frames)
    starts = np.concatenate([[math.floor((poses.shape[1] - 1) / 2 + 0.5)], ends[:-1]])
    left, bottom, right, top = bounds(world)
    frame = np.array([left, top, size / (right - left), size / (top - bottom)])
    radii = np.array([robot.body.visible_radius * RELATIVE_WIDTH for robot in world.robots])
    out = np.zeros((len(poses), frames, size, size), dtype=np.uint8)

    def draw(first: int) -> None:
        _draw_paths(poses[first : first + WORLDS_PER_TASK], starts, ends, radii, frame, out[first : first + WORLDS_PER_TASK])

    with ThreadPoolExecutor(threads or available_cores()) as pool:
        list(pool.map(draw, range(0, len(poses), WORLDS_PER_TASK)))
    return out


@compiled()
def _draw_paths(poses: Array, starts: Indices, ends: Indices, radii: Array, frame: Array, out: Grey) -> None:
    """Lay a disc wherever a robot was, later ones lighter; a robot that is not finite or not in the picture is left out."""
    size, scale = out.shape[2], math.sqrt(frame[2] * frame[3])
    for world, k in np.ndindex(out.shape[0], out.shape[1]):
        for tick in range(starts[k] + 1, ends[k] + 1):
            grey = PATH_GREY * (tick - starts[k]) / (ends[k] - starts[k])
            for robot in range(poses.shape[2]):
                x = (poses[world, tick, robot, 0] - frame[0]) * frame[2]
                y = (frame[1] - poses[world, tick, robot, 1]) * frame[3]
                if not (-size < x < 2 * size and -size < y < 2 * size):
                    continue
                # half a pixel beyond the disc its edge still covers a part of a pixel
                reach_x, reach_y = (radii[robot] + 0.5 / scale) * frame[2], (radii[robot] + 0.5 / scale) * frame[3]
                for row in range(max(0, math.floor(y - reach_y)), min(size, math.floor(y + reach_y) + 1)):
                    for column in range(max(0, math.floor(x - reach_x)), min(size, math.floor(x + reach_x) + 1)):
                        across, down = (column + 0.5 - x) / frame[2], (row + 0.5 - y) / frame[3]
                        cover = min(1.0, (radii[robot] - math.sqrt(across * across + down * down)) * scale + 0.5)
                        if cover * grey > out[world, k, row, column]:
                            out[world, k, row, column] = math.floor(cover * grey + 0.5)

"""The paper's greyscale videos straight from a batch of trajectories, compiled.

The authors draw 513 x 426 px, robots light on black, and shrink to 64 x 64. Here each robot is drawn once for every heading and every
position within a pixel, on a grid of 8 x 8 points a pixel (512 x 512 for 64 x 64, so the authors' pixel), averaged over pixels, and the
small pictures that result, the stamps, are added where robots are. That equals drawing at 512 x 512 and averaging 8 x 8 blocks, positions
rounded to the finer grid and headings to 64 directions, and costs a microsecond.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Protocol

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

from swarm_envs.compiled import compiled
from swarm_envs.cores import available_cores
from swarm_envs.rendering.view import bounds
from swarm_envs.worlds.spec import PushableObject, WorldSpec

Array = npt.NDArray[np.float64]
Grey = npt.NDArray[np.uint8]
Indices = npt.NDArray[np.int64]

FINE = 8
"""Points along each side of a pixel."""
DIRECTIONS = 64
"""Headings that a robot is drawn at."""
BODY = 160
"""Grey of the visible disc."""
MARK = 255
"""Grey of the heading mark and of the contact disc's outline."""
FIXED = 96
"""Grey of obstacles and of what lies outside the arena."""
PUSHED = 128
"""Grey of pushable objects."""
LINE = 1 / 300
"""Width in m of the contact disc's outline: one of the authors' pixels."""
MARK_WIDTH = 3 / 300
"""Width in m of the heading mark: three of the authors' pixels."""
MARK_LENGTH = 1.7
"""Length of the heading mark over the visible radius."""
CHUNK = 256
"""Worlds that one task draws."""


class _Trajectories(Protocol):
    @property
    def poses(self) -> Array: ...

    @property
    def world(self) -> WorldSpec: ...


def frame_indices(recorded: int, frames: int = 3) -> Indices:
    """Return which recorded frames a video shows: evenly spaced over the last half of the run, its last frame included.

    The last half falls into ``frames`` equal parts and the video shows the end of each: of 601 recorded frames (frame 0 is the start) and
    three shown, frames 400, 500 and 600. In general frame ``round((recorded - 1) (1/2 + k / (2 frames)))`` for k = 1 ... frames.

    Raises:
        ValueError: When ``frames`` is not a positive whole number.
    """
    if isinstance(frames, bool) or not isinstance(frames, int | np.integer) or frames < 1:
        raise ValueError(f"frames is {frames!r}, expected a positive whole number")
    k = np.arange(1, frames + 1)
    return np.floor((recorded - 1) * (0.5 + k / (2 * frames)) + 0.5).astype(np.int64)


def videos(trajectories: _Trajectories, frames: int = 3, size: int = 64, *, threads: int | None = None) -> Grey:
    """Draw a batch as the paper's greyscale videos.

    A black floor, stretched from the arena's bounding box (1.70 x 1.42 m in the paper) to a square; each robot a grey visible disc, the
    outline of its contact disc, one of the authors' pixels wide, and a white mark along its heading; obstacles and the outside of an arena
    that is not a rectangle in dark grey, pushable objects (where the trajectories hold ``object_poses``) a little lighter.

    Args:
        trajectories: Poses (worlds, frames, robots, 3) in m, m, rad and their world.
        frames: Pictures per video, see :func:`frame_indices`.
        size: Side of a picture in pixels, 8 to 512.
        threads: Threads to draw with, by default one per core; the result does not depend on it.

    Returns:
        (worlds, frames, size, size) uint8, row 0 the top (greatest y).

    Raises:
        ValueError: On a size or number of frames that makes no picture.
    """
    if isinstance(size, bool) or not isinstance(size, int | np.integer) or not 8 <= size <= 512:
        raise ValueError(f"size is {size!r}, expected a whole number from 8 to 512")
    world, poses = trajectories.world, trajectories.poses
    shown = frame_indices(poses.shape[1], frames)
    stage = _Stage(world, int(size))
    out = np.empty((len(poses), len(shown), size, size), dtype=np.uint8)
    objects = getattr(trajectories, "object_poses", None)

    def draw(first: int) -> None:
        part = slice(first, first + CHUNK)
        still = stage.still if objects is None or not world.objects else stage.with_objects(world.objects, objects[part][:, shown])
        _draw(poses[part], shown, stage.stamps, stage.models, stage.frame, still, out[part])

    starts = range(0, len(poses), CHUNK)
    with ThreadPoolExecutor(threads or available_cores()) as pool:
        list(pool.map(draw, starts))
    return out


class _Stage:
    """What all pictures of one world share.

    Attributes:
        frame: (4,) left and top in m, pixels per metre along x and y.
        stamps: (models, FINE, FINE, DIRECTIONS, rows, columns) uint8.
        models: (robots,) which stamp each robot takes.
        still: (1, 1, size, size) uint8, the floor and what never moves.
    """

    def __init__(self, world: WorldSpec, size: int) -> None:
        left, bottom, right, top = bounds(world)
        self.size = size
        self.frame = np.array([left, top, size / (right - left), size / (top - bottom)])
        bodies = [(robot.body.contact_radius, robot.body.visible_radius) for robot in world.robots]
        kinds = sorted(set(bodies))
        self.models = np.array([kinds.index(body) for body in bodies], dtype=np.int64)
        self.stamps = _stamps(tuple(kinds), float(self.frame[2]), float(self.frame[3]))
        self.still = self._still(world)[None, None]

    def _canvas(self, fill: int) -> tuple[Image.Image, ImageDraw.ImageDraw]:
        image = Image.new("L", (self.size * FINE, self.size * FINE), fill)
        return image, ImageDraw.Draw(image)

    def _corners(self, points: npt.ArrayLike) -> list[tuple[float, float]]:
        xy = np.asarray(points, dtype=np.float64)
        fine = np.stack([xy[:, 0] - self.frame[0], self.frame[1] - xy[:, 1]], axis=1) * self.frame[2:] * FINE
        return [(float(x), float(y)) for x, y in fine - 0.5]

    def _still(self, world: WorldSpec) -> Grey:
        image, draw = self._canvas(FIXED)
        draw.polygon(self._corners(world.arena.outline), fill=0)
        for obstacle in world.arena.obstacles:
            draw.polygon(self._corners(obstacle.outline), fill=FIXED)
        return np.array(image.reduce(FINE), dtype=np.uint8)

    def with_objects(self, objects: Sequence[PushableObject], poses: Array) -> Grey:
        """Add pushable objects at poses (worlds, frames, objects, 3) to the floor: (worlds, frames, size, size)."""
        out = np.empty((*poses.shape[:2], self.size, self.size), dtype=np.uint8)
        for index in np.ndindex(*poses.shape[:2]):
            image, draw = self._canvas(0)
            for item, pose in zip(objects, poses[index], strict=True):
                if np.isfinite(pose).all():
                    draw.polygon(self._corners(_outline(item, pose)), fill=PUSHED)
            out[index] = np.maximum(self.still[0, 0], np.array(image.reduce(FINE), dtype=np.uint8))
        return out


def _outline(item: PushableObject, pose: Array) -> Array:
    """Corners (n, 2) in m of an object's footprint."""
    if item.shape == "disc":
        turn = np.linspace(0, 2 * np.pi, 32, endpoint=False)
        return np.stack([pose[0] + item.size[0] * np.cos(turn), pose[1] + item.size[0] * np.sin(turn)], axis=1)
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array(item.size) / 2
    cosine, sine = math.cos(pose[2]), math.sin(pose[2])
    return np.asarray(corners @ np.array([[cosine, sine], [-sine, cosine]]) + pose[:2], dtype=np.float64)


@functools.lru_cache(maxsize=16)
def _stamps(kinds: tuple[tuple[float, float], ...], scale_x: float, scale_y: float) -> Grey:
    """Draw every kind of robot (contact and visible radius in m) for every place within a pixel and every heading."""
    reach = max(max(contact + LINE, MARK_LENGTH * visible) for contact, visible in kinds)
    rows, columns = (2 * math.ceil(reach * scale) + 1 for scale in (scale_y, scale_x))
    stamps = np.empty((len(kinds), FINE, FINE, DIRECTIONS, rows, columns), dtype=np.uint8)
    for kind, (contact, visible) in enumerate(kinds):
        _fill_stamps(stamps[kind], contact, visible, scale_x, scale_y)
    stamps.flags.writeable = False
    return stamps


@compiled()
def _fill_stamps(stamps: Grey, contact: float, visible: float, scale_x: float, scale_y: float) -> None:
    rows, columns = stamps.shape[3], stamps.shape[4]
    for place_y, place_x, turn in np.ndindex(FINE, FINE, DIRECTIONS):
        angle = 2 * math.pi * turn / DIRECTIONS
        cosine, sine = math.cos(angle), math.sin(angle)
        centre_x, centre_y = columns // 2 + (place_x + 0.5) / FINE, rows // 2 + (place_y + 0.5) / FINE
        for row, column in np.ndindex(rows, columns):
            total = 0
            for point in range(FINE * FINE):
                x = (column + (point % FINE + 0.5) / FINE - centre_x) / scale_x
                y = -(row + (point // FINE + 0.5) / FINE - centre_y) / scale_y
                total += _shade(x, y, cosine, sine, contact, visible)
            stamps[place_y, place_x, turn, row, column] = (total + FINE * FINE // 2) // (FINE * FINE)


@compiled(inline="always")
def _shade(x: float, y: float, cosine: float, sine: float, contact: float, visible: float) -> int:
    """Grey of a robot at a point (m, from its centre)."""
    along, across = x * cosine + y * sine, y * cosine - x * sine
    if 0 <= along <= MARK_LENGTH * visible and abs(across) <= MARK_WIDTH / 2:
        return MARK
    distance = math.sqrt(x * x + y * y)
    if contact - LINE <= distance <= contact:
        return MARK
    return BODY if distance <= visible else 0


@compiled()
def _draw(poses: Array, shown: Indices, stamps: Grey, models: Indices, frame: Array, still: Grey, out: Grey) -> None:
    """Copy the floor and add a stamp per robot, saturating; a robot that is not finite or not in the picture is left out."""
    size, rows, columns = out.shape[2], stamps.shape[4], stamps.shape[5]
    for world, k in np.ndindex(out.shape[0], out.shape[1]):
        canvas = out[world, k]
        canvas[:] = still[min(world, still.shape[0] - 1), min(k, still.shape[1] - 1)]
        for robot in range(poses.shape[2]):
            x = (poses[world, shown[k], robot, 0] - frame[0]) * frame[2]
            y = (frame[1] - poses[world, shown[k], robot, 1]) * frame[3]
            turn = poses[world, shown[k], robot, 2] * (DIRECTIONS / (2 * math.pi))
            if not (-columns < x < size + columns and -rows < y < size + rows and abs(turn) < 1e15):
                continue
            fine_x, fine_y = math.floor(x * FINE), math.floor(y * FINE)
            top, left = fine_y // FINE - rows // 2, fine_x // FINE - columns // 2
            stamp = stamps[models[robot], fine_y % FINE, fine_x % FINE, math.floor(turn + 0.5) % DIRECTIONS]
            for row in range(max(0, -top), min(rows, size - top)):
                for column in range(max(0, -left), min(columns, size - left)):
                    grey = int(canvas[top + row, left + column]) + int(stamp[row, column])
                    canvas[top + row, left + column] = min(grey, 255)

"""The paper's greyscale videos straight from a batch of trajectories, compiled.

The authors draw 513 x 426 px, robots light on black, and shrink to 64 x 64. Here each robot is drawn once for every heading and every
position within a pixel, on a grid of 8 x 8 points per pixel (512 x 512 for 64 x 64, so the authors' pixel), averaged over pixels, and the
small pictures that result, the sprites, are added where robots are. That equals drawing at 512 x 512 and averaging 8 x 8 blocks, positions
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

SUBPIXELS = 8
"""Points along each side of a pixel."""
HEADINGS = 64
"""Headings that a robot is drawn at."""
BODY_GREY = 160
"""Grey of the visible disc."""
MARK_GREY = 255
"""Grey of the heading mark and of the contact disc's outline."""
OBSTACLE_GREY = 96
"""Grey of obstacles and of what lies outside the arena."""
OBJECT_GREY = 128
"""Grey of pushable objects."""
OUTLINE_WIDTH = 1 / 300
"""Width in m of the contact disc's outline: one of the authors' pixels."""
MARK_WIDTH = 3 / 300
"""Width in m of the heading mark: three of the authors' pixels."""
MARK_LENGTH = 1.7
"""Length of the heading mark over the visible radius."""
WORLDS_PER_TASK = 256
"""Worlds that one task draws."""


class _PoseRecording(Protocol):
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


def videos(trajectories: _PoseRecording, frames: int = 3, size: int = 64, *, threads: int | None = None) -> Grey:
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
    scene = _Scene(world, int(size))
    out = np.empty((len(poses), len(shown), size, size), dtype=np.uint8)
    objects = getattr(trajectories, "object_poses", None)

    def draw(first: int) -> None:
        part = slice(first, first + WORLDS_PER_TASK)
        background = (
            scene.background if objects is None or not world.objects else scene.with_objects(world.objects, objects[part][:, shown])
        )
        _draw(poses[part], shown, scene.sprites, scene.sprite_kinds, scene.frame, background, out[part])

    starts = range(0, len(poses), WORLDS_PER_TASK)
    with ThreadPoolExecutor(threads or available_cores()) as pool:
        list(pool.map(draw, starts))
    return out


class _Scene:
    """What all pictures of one world share.

    Attributes:
        frame: (4,) left and top in m, pixels per metre along x and y.
        sprites: (kinds, SUBPIXELS, SUBPIXELS, HEADINGS, rows, columns) uint8.
        sprite_kinds: (robots,) which kind of sprite each robot takes.
        background: (1, 1, size, size) uint8, the floor and what never moves.
    """

    def __init__(self, world: WorldSpec, size: int) -> None:
        left, bottom, right, top = bounds(world)
        self.size = size
        self.frame = np.array([left, top, size / (right - left), size / (top - bottom)])
        bodies = [(robot.body.contact_radius, robot.body.visible_radius) for robot in world.robots]
        kinds = sorted(set(bodies))
        self.sprite_kinds = np.array([kinds.index(body) for body in bodies], dtype=np.int64)
        self.sprites = _make_sprites(tuple(kinds), float(self.frame[2]), float(self.frame[3]))
        self.background = self._draw_background(world)[None, None]

    def _canvas(self, fill: int) -> tuple[Image.Image, ImageDraw.ImageDraw]:
        image = Image.new("L", (self.size * SUBPIXELS, self.size * SUBPIXELS), fill)
        return image, ImageDraw.Draw(image)

    def _corners(self, points: npt.ArrayLike) -> list[tuple[float, float]]:
        xy = np.asarray(points, dtype=np.float64)
        fine = np.stack([xy[:, 0] - self.frame[0], self.frame[1] - xy[:, 1]], axis=1) * self.frame[2:] * SUBPIXELS
        return [(float(x), float(y)) for x, y in fine - 0.5]

    def _draw_background(self, world: WorldSpec) -> Grey:
        image, draw = self._canvas(OBSTACLE_GREY)
        draw.polygon(self._corners(world.arena.outline), fill=0)
        for obstacle in world.arena.obstacles:
            draw.polygon(self._corners(obstacle.outline), fill=OBSTACLE_GREY)
        return np.array(image.reduce(SUBPIXELS), dtype=np.uint8)

    def with_objects(self, objects: Sequence[PushableObject], poses: Array) -> Grey:
        """Add pushable objects at poses (worlds, frames, objects, 3) to the floor: (worlds, frames, size, size)."""
        out = np.empty((*poses.shape[:2], self.size, self.size), dtype=np.uint8)
        for index in np.ndindex(*poses.shape[:2]):
            image, draw = self._canvas(0)
            for item, pose in zip(objects, poses[index], strict=True):
                if np.isfinite(pose).all():
                    draw.polygon(self._corners(_outline(item, pose)), fill=OBJECT_GREY)
            out[index] = np.maximum(self.background[0, 0], np.array(image.reduce(SUBPIXELS), dtype=np.uint8))
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
def _make_sprites(kinds: tuple[tuple[float, float], ...], scale_x: float, scale_y: float) -> Grey:
    """Draw every kind of robot (contact and visible radius in m) for every place within a pixel and every heading."""
    reach = max(max(contact + OUTLINE_WIDTH, MARK_LENGTH * visible) for contact, visible in kinds)
    rows, columns = (2 * math.ceil(reach * scale) + 1 for scale in (scale_y, scale_x))
    sprites = np.empty((len(kinds), SUBPIXELS, SUBPIXELS, HEADINGS, rows, columns), dtype=np.uint8)
    for kind, (contact, visible) in enumerate(kinds):
        _fill_sprites(sprites[kind], contact, visible, scale_x, scale_y)
    sprites.flags.writeable = False
    return sprites


@compiled()
def _fill_sprites(sprites: Grey, contact: float, visible: float, scale_x: float, scale_y: float) -> None:
    rows, columns = sprites.shape[3], sprites.shape[4]
    for subpixel_y, subpixel_x, turn in np.ndindex(SUBPIXELS, SUBPIXELS, HEADINGS):
        angle = 2 * math.pi * turn / HEADINGS
        cosine, sine = math.cos(angle), math.sin(angle)
        centre_x, centre_y = columns // 2 + (subpixel_x + 0.5) / SUBPIXELS, rows // 2 + (subpixel_y + 0.5) / SUBPIXELS
        for row, column in np.ndindex(rows, columns):
            total = 0
            for point in range(SUBPIXELS * SUBPIXELS):
                x = (column + (point % SUBPIXELS + 0.5) / SUBPIXELS - centre_x) / scale_x
                y = -(row + (point // SUBPIXELS + 0.5) / SUBPIXELS - centre_y) / scale_y
                total += _shade(x, y, cosine, sine, contact, visible)
            sprites[subpixel_y, subpixel_x, turn, row, column] = (total + SUBPIXELS * SUBPIXELS // 2) // (SUBPIXELS * SUBPIXELS)


@compiled(inline="always")
def _shade(x: float, y: float, cosine: float, sine: float, contact: float, visible: float) -> int:
    """Grey of a robot at a point (m, from its centre)."""
    along, across = x * cosine + y * sine, y * cosine - x * sine
    if 0 <= along <= MARK_LENGTH * visible and abs(across) <= MARK_WIDTH / 2:
        return MARK_GREY
    distance = math.sqrt(x * x + y * y)
    if contact - OUTLINE_WIDTH <= distance <= contact:
        return MARK_GREY
    return BODY_GREY if distance <= visible else 0


@compiled()
def _draw(poses: Array, shown: Indices, sprites: Grey, sprite_kinds: Indices, frame: Array, background: Grey, out: Grey) -> None:
    """Copy the floor and add a sprite per robot, saturating; a robot that is not finite or not in the picture is left out."""
    size, rows, columns = out.shape[2], sprites.shape[4], sprites.shape[5]
    for world, k in np.ndindex(out.shape[0], out.shape[1]):
        canvas = out[world, k]
        canvas[:] = background[min(world, background.shape[0] - 1), min(k, background.shape[1] - 1)]
        for robot in range(poses.shape[2]):
            x = (poses[world, shown[k], robot, 0] - frame[0]) * frame[2]
            y = (frame[1] - poses[world, shown[k], robot, 1]) * frame[3]
            turn = poses[world, shown[k], robot, 2] * (HEADINGS / (2 * math.pi))
            if not (-columns < x < size + columns and -rows < y < size + rows and abs(turn) < 1e15):
                continue
            fine_x, fine_y = math.floor(x * SUBPIXELS), math.floor(y * SUBPIXELS)
            top, left = fine_y // SUBPIXELS - rows // 2, fine_x // SUBPIXELS - columns // 2
            sprite = sprites[sprite_kinds[robot], fine_y % SUBPIXELS, fine_x % SUBPIXELS, math.floor(turn + 0.5) % HEADINGS]
            for row in range(max(0, -top), min(rows, size - top)):
                for column in range(max(0, -left), min(columns, size - left)):
                    grey = int(canvas[top + row, left + column]) + int(sprite[row, column])
                    canvas[top + row, left + column] = min(grey, 255)

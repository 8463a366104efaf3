"""From metres in the arena to pixels in a picture."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw

from swarm_envs.rendering.palette import FLOOR, OBSTACLE, WALL, Colour
from swarm_envs.worlds.spec import Polygon, WorldSpec

SNAP = 0.01
"""A scale is rounded down to whole pixels per centimetre where that costs less than this share of the width."""
SUPERSAMPLING = 4
"""Each pixel of the still background is the mean of this many squared."""


@dataclass(frozen=True)
class View:
    """A picture's size, and where a point of the arena lies in it: ``column = left + scale x``, ``row = top - scale y``."""

    width: int
    """Picture width in pixels."""
    height: int
    """Picture height in pixels."""
    scale: float
    """Pixels per metre, the same along x and y."""
    left: float
    """Column of x = 0."""
    top: float
    """Row of y = 0."""

    def pixels(self, points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Map points (..., 2 or more) in m to columns and rows (..., 2)."""
        return np.stack([self.left + self.scale * points[..., 0], self.top - self.scale * points[..., 1]], axis=-1)


def bounds(world: WorldSpec) -> tuple[float, float, float, float]:
    """Return the rectangle that a picture shows, (left, bottom, right, top) in m: the outline's box and its picture border."""
    xs, ys = zip(*world.arena.outline, strict=True)
    border = world.arena.picture_border
    return min(xs) - border, min(ys) - border, max(xs) + border, max(ys) + border


def view_of(world: WorldSpec, width: int = 513, height: int | None = None) -> View:
    """Return the view that shows a whole world, centred, at one scale.

    The scale is the largest that fits. Where rounding it down to whole pixels per centimetre costs less than 1 % it is rounded: the
    paper's arena of 1.70 x 1.42 m at width 513 is drawn at 3 px/cm and is 426 px high, as in the authors' simulator; the 1.5 px that
    stay free on the left and on the right show wall.

    Args:
        world: The world.
        width: Picture width in pixels.
        height: Picture height in pixels; by default what the arena needs.

    Raises:
        ValueError: When a side is not a positive whole number.
    """
    for name, side in (("width", width), ("height", height)):
        if side is not None and (isinstance(side, bool) or not isinstance(side, int | np.integer) or side < 1):
            raise ValueError(f"{name} is {side!r}, expected a positive whole number of pixels")
    left, bottom, right, top = bounds(world)
    scale = width / (right - left)
    if height is not None:
        scale = min(scale, height / (top - bottom))
    snapped = 100.0 * math.floor(scale / 100.0 + 1e-9)
    if snapped > (1 - SNAP) * scale:
        scale = snapped
    rows = max(1, round(scale * (top - bottom))) if height is None else height
    return View(
        width=int(width),
        height=int(rows),
        scale=scale,
        left=width / 2 - scale * (left + right) / 2,
        top=rows / 2 + scale * (bottom + top) / 2,
    )


def background(world: WorldSpec, view: View) -> npt.NDArray[np.uint8]:
    """Draw what never moves, (height, width, 3) uint8: the floor, the walls around it with a thin inner edge, the obstacles."""
    many = SUPERSAMPLING
    image = Image.new("RGB", (view.width * many, view.height * many), WALL)
    draw = ImageDraw.Draw(image)
    _polygon(draw, view, world.arena.outline, FLOOR, WALL)
    for obstacle in world.arena.obstacles:
        _polygon(draw, view, obstacle.outline, OBSTACLE, WALL)
    return np.array(image.reduce(many), dtype=np.uint8)


def _polygon(draw: ImageDraw.ImageDraw, view: View, outline: Polygon, fill: Colour, edge: Colour) -> None:
    corners = [tuple(p) for p in view.pixels(np.array(outline, dtype=np.float64)) * SUPERSAMPLING - 0.5]
    draw.polygon(corners, fill=fill)
    draw.line([*corners, corners[0], corners[1]], fill=edge, width=2 * SUPERSAMPLING, joint="curve")

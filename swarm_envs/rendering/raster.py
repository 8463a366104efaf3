"""Anti-aliased shapes on an RGB canvas, compiled.

Every shape is its signed distance: a pixel whose centre lies a distance d inside the edge is covered by d + 1/2, clipped to [0, 1]. The
canvas is uint8 (height, width, 3); coordinates are pixels, x to the right, y down, pixel (row i, column j) has its centre at
(j + 1/2, i + 1/2). Shapes may lie anywhere; what falls outside the canvas is dropped. A shape with a coordinate that is not finite, or
further than a million pixels away, is not drawn.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from swarm_envs.compiled import compiled

Canvas = npt.NDArray[np.uint8]
ColourArray = npt.NDArray[np.uint8]

MAX_COORDINATE = 1e6
"""Greatest coordinate in pixels that is drawn; keeps the loops' bounds within integers."""


@compiled(inline="always")
def blend(canvas: Canvas, row: int, column: int, colour: ColourArray, alpha: float) -> None:
    """Mix a colour into one pixel, ``alpha`` from 0 (nothing) to 1 (opaque)."""
    for channel in range(3):
        old = float(canvas[row, column, channel])
        canvas[row, column, channel] = np.uint8(old + alpha * (float(colour[channel]) - old) + 0.5)


@compiled(inline="always")
def pixel_range(low: float, high: float, length: int) -> Any:
    """The rows (or columns) ``first, end`` of a canvas of this length whose pixels meet ``[low, high]``."""
    if not (low > -MAX_COORDINATE and high < MAX_COORDINATE):
        return 0, 0
    return max(0, math.floor(low)), min(length, math.floor(high) + 1)


@compiled()
def annulus(canvas: Canvas, x: float, y: float, inner: float, outer: float, colour: ColourArray, alpha: float) -> None:
    """Draw a disc with a concentric hole; a full disc when ``inner`` is negative."""
    top, bottom = pixel_range(y - outer - 1, y + outer + 1, canvas.shape[0])
    left, right = pixel_range(x - outer - 1, x + outer + 1, canvas.shape[1])
    for row in range(top, bottom):
        for column in range(left, right):
            distance = math.hypot(column + 0.5 - x, row + 0.5 - y)
            cover = min(outer - distance + 0.5, 1.0)
            if inner > 0:
                cover = min(cover, distance - inner + 0.5)
            if cover > 0:
                blend(canvas, row, column, colour, alpha * cover)


@compiled()
def box(
    canvas: Canvas, x: float, y: float, angle: float, half_x: float, half_y: float, rounding: float, colour: ColourArray, alpha: float
) -> None:
    """Draw a turned rectangle, its corners rounded with this radius; ``angle`` is counter-clockwise as seen on the picture."""
    reach = math.hypot(half_x, half_y) + 1
    cosine, sine = math.cos(angle), -math.sin(angle)
    top, bottom = pixel_range(y - reach, y + reach, canvas.shape[0])
    left, right = pixel_range(x - reach, x + reach, canvas.shape[1])
    for row in range(top, bottom):
        for column in range(left, right):
            dx, dy = column + 0.5 - x, row + 0.5 - y
            over_x = abs(dx * cosine + dy * sine) - half_x + rounding
            over_y = abs(dy * cosine - dx * sine) - half_y + rounding
            distance = math.hypot(max(over_x, 0.0), max(over_y, 0.0)) + min(max(over_x, over_y), 0.0) - rounding
            if distance < 0.5:
                blend(canvas, row, column, colour, alpha * min(0.5 - distance, 1.0))


@compiled()
def stroke(canvas: Canvas, x0: float, y0: float, x1: float, y1: float, width: float, colour: ColourArray, alpha: float) -> None:
    """Draw one piece of a polyline: the pixels nearest to it, its end excluded, so that translucent pieces do not add up at joints."""
    dx, dy = x1 - x0, y1 - y0
    length = math.hypot(dx, dy)
    reach = width / 2 + 1
    top, bottom = pixel_range(min(y0, y1) - reach, max(y0, y1) + reach, canvas.shape[0])
    left, right = pixel_range(min(x0, x1) - reach, max(x0, x1) + reach, canvas.shape[1])
    if length < 1e-6:
        return
    for row in range(top, bottom):
        for column in range(left, right):
            px, py = column + 0.5 - x0, row + 0.5 - y0
            along = (px * dx + py * dy) / length
            if 0 <= along < length:
                cover = width / 2 - abs(px * dy - py * dx) / length + 0.5
                if cover > 0:
                    blend(canvas, row, column, colour, alpha * min(cover, min(width, 1.0)))


@compiled()
def sector(
    canvas: Canvas, x: float, y: float, angle: float, half_angle: float, radius: float, colour: ColourArray, alpha: float, far_alpha: float
) -> None:
    """Draw a slice of a disc whose opacity falls from ``alpha`` at the tip to ``far_alpha`` at the arc; ``angle`` as in :func:`box`."""
    cosine, sine = math.cos(angle), -math.sin(angle)
    edge_c, edge_s = math.cos(half_angle), math.sin(half_angle)
    top, bottom = pixel_range(y - radius - 1, y + radius + 1, canvas.shape[0])
    for row in range(top, bottom):
        dy = row + 0.5 - y
        if abs(dy) > radius + 1:
            continue
        chord = math.sqrt((radius + 1) ** 2 - dy * dy)
        low, high = x - chord, x + chord
        if half_angle < 1.5:  # clip the row to the two straight edges, each a half plane that grows by a pixel
            for side in (-1.0, 1.0):
                slope = edge_s * cosine + side * edge_c * sine
                rest = (edge_s * sine - side * edge_c * cosine) * dy + 1.0
                if slope > 1e-9:
                    low = max(low, x - rest / slope)
                elif slope < -1e-9:
                    high = min(high, x - rest / slope)
                elif rest < 0:
                    high = low - 1
        if high < low:
            continue
        left, right = pixel_range(low - 1, high + 1, canvas.shape[1])
        for column in range(left, right):
            dx = column + 0.5 - x
            along, across = dx * cosine + dy * sine, abs(dy * cosine - dx * sine)
            distance = math.hypot(dx, dy)
            edge = along * edge_s - across * edge_c
            if half_angle >= math.pi - 1e-9:
                edge = 1.0
            cover = min(1.0, radius - distance + 0.5, edge + 0.5)
            if cover > 0:
                share = min(distance / radius, 1.0)
                blend(canvas, row, column, colour, cover * (alpha + (far_alpha - alpha) * share))

"""A few solids by their edges instead of their centres: most of the parts read as stock minus holes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from build123d import Axis, Box, Cylinder, Part, Plane, Polygon, Pos, RegularPolygon, Rot, Torus, extrude

Range = tuple[float, float]
"""Lower and upper bound in mm."""


def block(x: Range, y: Range, z: Range) -> Part:
    """Return the box between these bounds."""
    size = (x[1] - x[0], y[1] - y[0], z[1] - z[0])
    return Pos((x[0] + x[1]) / 2, (y[0] + y[1]) / 2, (z[0] + z[1]) / 2) * Box(*size)


def rounded(x: Range, y: Range, z: Range, radius: float) -> Part:
    """Return the box between these bounds with its upright edges rounded."""
    solid = block(x, y, z)
    return solid.fillet(radius, solid.edges().filter_by(Axis.Z))


def rod(x: float, y: float, z: Range, diameter: float) -> Part:
    """Return an upright cylinder."""
    return Pos(x, y, (z[0] + z[1]) / 2) * Cylinder(diameter / 2, z[1] - z[0])


def rod_y(x: float, z: float, y: Range, diameter: float) -> Part:
    """Return a cylinder along y."""
    return Pos(x, (y[0] + y[1]) / 2, z) * Rot(90, 0, 0) * Cylinder(diameter / 2, y[1] - y[0])


def torus_y(z: float, y: float, major: float, minor: float) -> Part:
    """Return a torus about an axis along y."""
    return Pos(0, y, z) * Rot(90, 0, 0) * Torus(major, minor)


def hexagon(x: float, y: float, z: Range, flats: float, turn: float = 0.0) -> Part:
    """Return an upright hexagonal prism; ``turn`` in degrees."""
    face = Pos(x, y, z[0]) * Rot(0, 0, turn) * RegularPolygon(flats / 2, 6, major_radius=False)
    return extrude(face, amount=z[1] - z[0], dir=(0, 0, 1))


def slot(x: float, y: float, z: Range, diameter: float, travel: float, angle: float) -> Part:
    """Return an upright slotted hole: ``diameter`` wide, moving ``travel`` either way along ``angle`` (degrees from x)."""
    bar = block((-travel, travel), (-diameter / 2, diameter / 2), z)
    ends = [rod(side * travel, 0, z, diameter) for side in (-1, 1)]
    return Pos(x, y, 0) * Rot(0, 0, angle) * joined(bar, ends)


def prism(points: Sequence[tuple[float, float]], z: Range) -> Part:
    """Return the upright prism over a polygon in the xy plane."""
    return extrude(Pos(0, 0, z[0]) * Polygon(*points, align=None), amount=z[1] - z[0], dir=(0, 0, 1))


def prism_y(points: Sequence[tuple[float, float]], y: Range) -> Part:
    """Return the prism along y over a polygon of (x, z) points."""
    plane = Plane(origin=(0, y[0], 0), x_dir=(1, 0, 0), z_dir=(0, -1, 0))
    return extrude(plane * Polygon(*points, align=None), amount=y[1] - y[0], dir=(0, 1, 0))


def joined(first: Part, others: Iterable[Part]) -> Part:
    """Return the union."""
    return first + list(others)


def cut(first: Part, others: Iterable[Part]) -> Part:
    """Return ``first`` without the others."""
    return first - list(others)


def turned(solid: Part, degrees: float) -> Part:
    """Return the solid turned about the robot's upright axis."""
    return Rot(0, 0, degrees) * solid


def polar(radius: float, degrees: float) -> tuple[float, float]:
    """Return (x, y) on a circle about the robot's upright axis."""
    return radius * math.cos(math.radians(degrees)), radius * math.sin(math.radians(degrees))


def four(x: float, y: float) -> list[tuple[float, float]]:
    """Return the four mirror images of a point about both axes."""
    return [(sx * x, sy * y) for sx in (1, -1) for sy in (1, -1)]

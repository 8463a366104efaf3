"""Battery tray: a closed trough for the pouch cell under the body plate, and the skids that its ends stand on."""

from __future__ import annotations

from build123d import Axis, Part

from hardware.cad.shapes import block, cut, joined, rod, rounded
from hardware.dimensions import Hardware

COLUMN = 9.0
"""Diameter of the columns that the skids' screws run through."""
CELL_PLAY = 0.5
"""Gap around the cell, each side: a pouch must never be pressed."""


def battery_tray(h: Hardware) -> Part:
    """Return the tray in robot position; it prints as it stands, floor on the bed."""
    return cut(_stock(h), _holes(h))


def rear_skid(h: Hardware) -> Part:
    """Return the skid that the robot slides on; it prints rim upwards."""
    return _skid(h, -h.skid_x, 0.0)


def front_skid(h: Hardware) -> Part:
    """Return the shorter skid that stops a nod."""
    return _skid(h, h.skid_x, h.front_skid_lift)


def _skid(h: Hardware, x: float, bottom: float) -> Part:
    """A foot with a rounded rim; its screw's head hides inside."""
    foot = rod(x, 0, (bottom, h.tray_floor), h.skid_diameter)
    foot = foot.fillet(1.0, foot.edges().group_by(Axis.Z)[0])
    head = rod(x, 0, (bottom - 1, bottom + h.skid_head), h.screws.m3_head)
    return cut(foot, [head, rod(x, 0, (bottom - 1, h.tray_floor + 1), h.screws.m3)])


def _stock(h: Hardware) -> Part:
    x, y = h.boards.cell[0] / 2 + CELL_PLAY, h.boards.cell[1] / 2 + CELL_PLAY
    wall = h.print.wall
    trough = rounded((-x - wall, x + wall), (-y - wall, y + wall), (h.tray_floor, h.plate_bottom), 2.0)
    room = block((-x, x), (-y, y), (h.tray_floor + wall, h.plate_bottom + 1))
    columns = []
    for side in (1, -1):
        columns.append(rod(side * h.skid_x, 0, (h.tray_floor, h.plate_bottom), COLUMN))
        inner, outer = sorted((side * (x + wall / 2), side * h.skid_x))
        columns.append(block((inner, outer), (-COLUMN / 2, COLUMN / 2), (h.tray_floor, h.plate_bottom)))
    return joined(cut(trough, [room]), columns)


def _holes(h: Hardware) -> list[Part]:
    """The skids' screws, and two pairs of notches for the tie that holds the cell on its foam."""
    notch = (h.plate_bottom - 2.5, h.plate_bottom + 1)
    screws = [rod(side * h.skid_x, 0, (0, h.plate_bottom + 1), h.screws.m3) for side in (1, -1)]
    return [*screws, block((-13, -10), (-60, 60), notch), block((10, 13), (-60, 60), notch)]

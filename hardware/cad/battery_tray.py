"""Battery tray: a closed trough for the pouch cell under the body plate, with the two skids at its ends."""

from __future__ import annotations

from build123d import Part

from hardware.cad.shapes import block, cut, hexagon, joined, rod, rounded
from hardware.dimensions import Hardware

COLUMN = 9.0
"""Diameter of the columns that the skids' screws run through."""
CELL_PLAY = 0.5
"""Gap around the cell, each side: a pouch must never be pressed."""


def battery_tray(h: Hardware) -> Part:
    """Return the tray in robot position; it prints as it stands, floor on the bed."""
    return cut(_stock(h), _holes(h))


def nut_seat(h: Hardware, front: bool) -> float:
    """Height of the dome nut's flat face: the rear nut touches the floor, the front one hangs ``front_skid_lift`` above it."""
    return h.dome_height + (h.front_skid_lift if front else 0.0)


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
    holes = []
    for side in (1, -1):
        x = side * h.skid_x
        holes.append(rod(x, 0, (0, h.plate_bottom + 1), h.screws.m3))
        holes.append(hexagon(x, 0, (0, nut_seat(h, side > 0)), h.screws.m3_nut))
    # two slots for a strap of foam or a cable tie, and a window that shows whether the cell swells
    holes += [block((-13, -10), (-60, 60), (h.plate_bottom - 2.5, h.plate_bottom + 1))]
    holes += [block((10, 13), (-60, 60), (h.plate_bottom - 2.5, h.plate_bottom + 1))]
    return holes

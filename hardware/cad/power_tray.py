"""Power tray: closes the servo pillars from above and carries the TP4056 charger and the MT3608 boost converter."""

from __future__ import annotations

from build123d import Part

from hardware.cad.body_plate import tray_screws
from hardware.cad.shapes import block, cut, joined, rod, rounded
from hardware.dimensions import Hardware

RIM = 1.6
"""Height and thickness of the rims that hold the boards in place."""
PLAY = 0.3
TIE = (3.2, 1.8)
"""Slot for a 2.5 mm cable tie."""
CHARGER_REAR = -36.4
"""Rear end of the charger's board; its socket looks backwards through the shield's window."""


def power_tray(h: Hardware) -> Part:
    """Return the tray in robot position; it prints as it stands."""
    return cut(_stock(h), _holes(h))


def charger_span(h: Hardware) -> tuple[float, float]:
    """Bounds along x of the charger."""
    return CHARGER_REAR, CHARGER_REAR + h.boards.charger[0]


def converter_span(h: Hardware) -> tuple[float, float]:
    """Bounds along x of the boost converter, which lies across."""
    low = charger_span(h)[1] + 0.5
    return low, low + h.boards.converter[1]


def _stock(h: Hardware) -> Part:
    bottom, top = h.pillar_top, h.pillar_top + h.tray_thickness
    front = tray_screws(h)[-1][0] + 3.0
    rear_half, front_half = h.boards.charger[1] / 2 + PLAY + RIM + 2.2, h.boards.converter[0] / 2 + PLAY + RIM
    plate = rounded((CHARGER_REAR, front), (-rear_half, rear_half), (bottom, top), 2.0)
    screw_y = tray_screws(h)[0][1] + 3.0
    wide = rounded((-24.3, front), (-screw_y, screw_y), (bottom, top), 2.0)
    cross = rounded((converter_span(h)[0] - 1, converter_span(h)[1] + 1), (-front_half, front_half), (bottom, top), 1.0)
    return joined(plate, [wide, cross, *_rims(h, top)])


def _rims(h: Hardware, top: float) -> list[Part]:
    """Rims beside the charger (open to the rear and where its wires leave) and at the converter's ends."""
    z = (top - 0.5, top + RIM)
    low, high = charger_span(h)
    half = h.boards.charger[1] / 2 + PLAY
    rims = []
    for side in (1, -1):
        inner, outer = sorted((side * half, side * (half + RIM)))
        rims.append(block((low, high - 6), (inner, outer), z))
        end = h.boards.converter[0] / 2 + PLAY
        inner, outer = sorted((side * end, side * (end + RIM)))
        middle = sum(converter_span(h)) / 2
        rims.append(block((middle - 4, middle + 4), (inner, outer), z))
    return rims


def _holes(h: Hardware) -> list[Part]:
    through = (h.pillar_top - 1, h.pillar_top + h.tray_thickness + RIM + 1)
    holes = [rod(x, y, through, h.screws.m2) for x, y in tray_screws(h)]
    half = h.boards.charger[1] / 2 + PLAY + RIM + TIE[1] / 2 - 0.1
    middle = charger_span(h)[0] + 8.0
    holes += [block((middle - TIE[0] / 2, middle + TIE[0] / 2), (s * half - TIE[1] / 2, s * half + TIE[1] / 2), through) for s in (1, -1)]
    low, high = converter_span(h)
    for x in (low - 0.2 - TIE[1] / 2, high + 0.2 + TIE[1] / 2):
        holes.append(block((x - TIE[1] / 2, x + TIE[1] / 2), (-TIE[0] / 2, TIE[0] / 2), through))
    return holes

"""Encoder disc: 48 slots whose two edges count, on the wheel's own shaft."""

from __future__ import annotations

import math

from build123d import Part, Pos, Rot

from hardware.cad.shapes import cut, joined, prism, rod
from hardware.cad.wheel import DISC_SCREW_RADIUS
from hardware.dimensions import Hardware

COLLAR = 3.0
"""Length of the collar that centres the disc on the shaft."""


def encoder_disc(h: Hardware) -> Part:
    """Return the left disc in robot position; it prints with its outer face on the bed, collar upwards."""
    outer = h.shaft_diameter / 2 + h.print.press
    blank = joined(
        rod(0, 0, (0, h.disc_thickness), 2 * h.disc_radius),
        [rod(0, 0, (0, h.disc_thickness + COLLAR), 2 * (outer + h.print.wall))],
    )
    holes = [
        rod(0, 0, (h.disc_thickness, h.disc_thickness + COLLAR + 1), 2 * outer),
        rod(0, 0, (-1, h.disc_thickness + 1), h.shaft_bore),
        *(rod(0, side * DISC_SCREW_RADIUS, (-1, h.disc_thickness + 1), h.screws.m2) for side in (1, -1)),
        *_slots(h),
    ]
    flat = cut(blank, holes)
    return Pos(0, h.disc_y + h.disc_thickness / 2, h.axle_height) * Rot(90, 0, 0) * flat


def _slots(h: Hardware) -> list[Part]:
    """Slots as wide as the teeth between them, at every radius."""
    inner, outer = h.track_radius - h.slot_reach, h.track_radius + h.slot_reach
    half = math.pi / h.encoder_slots / 2
    slots = []
    for index in range(h.encoder_slots):
        middle = 2 * math.pi * index / h.encoder_slots
        corners = [(inner, -half), (outer, -half), (outer, half), (inner, half)]
        slots.append(prism([(r * math.cos(middle + a), r * math.sin(middle + a)) for r, a in corners], (-1, h.disc_thickness + 1)))
    return slots

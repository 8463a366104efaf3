"""Encoder bracket: hangs the slotted switch over the disc, outside the wheel, and slides along the axle to centre its gap.

The switch's inner ear hangs over the tire, where there is no room for a screw's head: a printed peg locates it, a screw holds the
outer ear.
"""

from __future__ import annotations

from build123d import Part, Pos

from hardware.cad.shapes import block, cut, hexagon, joined, rod, slot
from hardware.dimensions import Hardware

PLATE = 2.0
"""Thickness of the wings that lie on the deck."""
WING = 17.0
"""Half width of the wings."""
PLUG = 7.7
"""Half width of the part that stands in the deck's window."""
WING_SCREW = (12.4, 44.5)
"""The screws in the deck, x (either side) and y."""


def encoder_bracket(h: Hardware) -> Part:
    """Return the left bracket in robot position; it prints upside down, wings on the bed."""
    return cut(_stock(h), _holes(h))


def plug_span(h: Hardware) -> tuple[float, float]:
    """Bounds along y of the plug: the switch with its ears and a little more."""
    return h.disc_y - h.switch.length / 2 - 0.8, h.disc_y + h.switch.length / 2 + 0.3


def ear_holes(h: Hardware) -> tuple[float, float]:
    """The y of the holes in the switch's inner and outer ear."""
    return (h.disc_y - h.switch.hole_pitch / 2, h.disc_y + h.switch.hole_pitch / 2)


def _stock(h: Hardware) -> Part:
    low, high = plug_span(h)
    top = h.deck_top + PLATE
    plug = block((-PLUG, PLUG), (low, high), (h.switch_base, top))
    peg = rod(0, ear_holes(h)[0], (h.switch_base - h.switch.ear_height + 0.2, h.switch_base), h.switch.hole - 2 * h.print.press)
    wings = block((-WING, WING), (h.wheel_outer + 1.5, high), (h.deck_top, top))
    inside = rod(0, 0, (0, 100), 2 * (h.deck_radius - h.bracket_travel))
    return joined(joined(plug, [wings]) & inside, [peg])


def _holes(h: Hardware) -> list[Part]:
    top = h.deck_top + PLATE
    through = (h.switch_base - 1, top + 1)
    holes = []
    outer = ear_holes(h)[1]
    holes.append(rod(0, outer, through, h.screws.m3))
    holes.append(hexagon(0, outer, (top - h.screws.m3_nut_height, top + 1), h.screws.m3_nut))
    holes += [slot(x, WING_SCREW[1], through, h.screws.m3, h.bracket_travel, 90) for x in (-WING_SCREW[0], WING_SCREW[0])]
    pins = block((-2.6, 2.6), (-1.2, 1.2), through)
    holes += [Pos(0, h.disc_y + side * h.switch.pin_pitch_length / 2, 0) * pins for side in (1, -1)]
    return holes

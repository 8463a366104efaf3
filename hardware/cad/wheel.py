"""Wheel with its encoder shaft: O-ring groove outside, pocket for the servo's horn inside, shaft for the disc on the outer face."""

from __future__ import annotations

import math

from build123d import Part, Pos, Rot

from hardware.cad.shapes import block, cut, joined, prism, rod_y, torus_y
from hardware.dimensions import Hardware

DISC_SCREW_RADIUS = 5.2
"""Circle of the two screws that hold the encoder disc on the shaft's end."""


def wheel(h: Hardware) -> Part:
    """Return the left wheel in robot position; it prints with the horn pocket on the bed, the shaft upwards."""
    rim = rod_y(0, h.axle_height, (h.wheel_inner, h.wheel_outer), h.rim_diameter)
    shaft = rod_y(0, h.axle_height, (h.wheel_outer, shaft_end(h)), h.shaft_diameter)
    return cut(joined(rim, [shaft]), [_groove(h), _bore(h), *_horn_pocket(h), *_lightening(h), *_disc_pilots(h)])


def shaft_end(h: Hardware) -> float:
    """The shaft's end face, against which the disc lies."""
    return h.disc_y - h.disc_thickness / 2


def _groove(h: Hardware) -> Part:
    minor = h.mounted_tire_section / 2 + 0.05
    return torus_y(h.axle_height, h.wheel_base / 2, h.groove_diameter / 2 + minor, minor)


def _bore(h: Hardware) -> Part:
    return rod_y(0, h.axle_height, (h.wheel_inner - 1, shaft_end(h) + 1), h.shaft_bore)


def _horn_pocket(h: Hardware) -> list[Part]:
    """The double arm's outline, and a slit through the web that the arm's two screws bite into at whatever radius its holes have."""
    play = h.horn.play
    hub = rod_y(0, h.axle_height, (h.wheel_inner - 1, h.horn_outer), h.horn.hub_diameter + 2 * play)
    reach, wide, narrow = h.horn.arm_span / 2 + play, h.horn.arm_width_hub / 2 + play, h.horn.arm_width_tip / 2 + play
    outline = [(-reach, -narrow), (0, -wide), (reach, -narrow), (reach, narrow), (0, wide), (-reach, narrow)]
    arms = _upright(h) * prism(outline, (-h.horn_outer, -h.wheel_inner + 1))
    slits = [
        block(span, (h.horn_outer - 0.1, h.wheel_outer + 1), (h.axle_height - 0.75, h.axle_height + 0.75))
        for span in ((8.5, 15.5), (-15.5, -8.5))
    ]
    return [hub, arms, *slits]


def _upright(h: Hardware) -> Pos:
    """Carries a drawing in the xy plane, thickness along -z, into the wheel's plane, thickness along y."""
    return Pos(0, 0, h.axle_height) * Rot(90, 0, 0)


def _lightening(h: Hardware) -> list[Part]:
    angles = [math.radians(a) for a in (50, 90, 130, 230, 270, 310)]
    return [rod_y(14.2 * math.cos(a), h.axle_height + 14.2 * math.sin(a), (h.wheel_inner - 1, h.wheel_outer + 1), 7.5) for a in angles]


def _disc_pilots(h: Hardware) -> list[Part]:
    end = shaft_end(h)
    return [rod_y(0, h.axle_height + side * DISC_SCREW_RADIUS, (end - 6, end + 1), h.screws.m2_pilot) for side in (1, -1)]

"""Deck: round plate over the wheels that joins chassis, shield, hat, encoder brackets and the carrier board."""

from __future__ import annotations

from build123d import Part, Pos, Rot

from hardware.cad.encoder_bracket import PLUG, WING_SCREW, plug_span
from hardware.cad.shapes import block, cut, four, hexagon, joined, polar, rod
from hardware.dimensions import Hardware

POST = 5.0
"""Height of the carrier board's standoffs."""
NUT_KEY = 1.2
"""Depth of the pockets that keep the hat's nuts from turning."""


def deck(h: Hardware) -> Part:
    """Return the deck in robot position; it prints as it stands, posts upwards."""
    posts = [rod(x, y, (h.deck_top, h.deck_top + POST), 6.0) for x, y in carrier_posts(h)]
    posts += [rod(x, y, (h.deck_top, h.deck_top + POST), h.ballast_post - 2 * h.print.press) for x, y in ballast_posts(h)]
    plate = rod(0, 0, (h.deck_bottom, h.deck_top), 2 * h.deck_radius)
    return cut(joined(plate, posts), [*_screw_holes(h), *_openings(h)])


def carrier_posts(h: Hardware) -> list[tuple[float, float]]:
    """Where the carrier board is screwed down; its long side lies across the robot."""
    along, across = h.boards.carrier_holes
    return four(across / 2, along / 2)


def ballast_posts(h: Hardware) -> list[tuple[float, float]]:
    """Where the M8 nuts that weigh the rear down are glued."""
    return [polar(h.rocker_radius, angle) for angle in h.ballast_angles]


def shield_screws(h: Hardware) -> list[tuple[float, float]]:
    """Where the shield's lugs are screwed to the deck."""
    return [polar(h.lug_radius, angle) for angle in (45, 135, 225, 315)]


def hat_screws(h: Hardware) -> list[tuple[float, float]]:
    """Where the hat's lugs are screwed to the deck."""
    return [polar(h.hat_lug_radius, angle) for angle in h.hat_lug_angles]


def _screw_holes(h: Hardware) -> list[Part]:
    through = (h.deck_bottom - 1, h.deck_top + 1)
    wings = four(*WING_SCREW)
    holes = [rod(x, y, through, h.screws.m3) for x, y in [*four(*h.standoff_xy), *shield_screws(h), *hat_screws(h), *wings]]
    holes += [hexagon(x, y, (h.deck_bottom - 1, h.deck_bottom + NUT_KEY), h.screws.m3_nut) for x, y in [*hat_screws(h), *wings]]
    holes += [rod(x, y, (h.deck_top - 1, h.deck_top + POST + 1), h.screws.m2_pilot) for x, y in carrier_posts(h)]
    return holes


def _openings(h: Hardware) -> list[Part]:
    through = (h.deck_bottom - 1, h.deck_top + 1)
    low = plug_span(h)[0] - h.bracket_travel - 0.3
    half = PLUG + h.print.slide
    windows = [block((-half, half), (low, 80), through), block((-half, half), (-80, -low), through)]
    wires = [rod(0, 0, through, 30.0), block((21.5, 26.0), (-11, 11), through), block((-26.0, -21.5), (-11, 11), through)]
    x, y = polar(h.rocker_radius, h.rocker_angle)
    across, along = h.boards.rocker[1], h.boards.rocker[0]
    place = Pos(x, y, 0) * Rot(0, 0, h.rocker_angle)
    rocker = [
        place * block((-across / 2, across / 2), (-along / 2, along / 2), through),
        # the switch's clips want a panel of at most 2 mm
        place * block((-across / 2 - 1.2, across / 2 + 1.2), (-along / 2 - 1.2, along / 2 + 1.2), (h.deck_bottom - 1, h.deck_top - 1.6)),
    ]
    return windows + wires + rocker

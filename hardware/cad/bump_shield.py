"""Bump shield: the ring that robots touch each other with, hung on the deck by four lugs."""

from __future__ import annotations

from build123d import Part, Rot

from hardware.cad.shapes import block, cut, joined, prism_y, rod, rounded
from hardware.dimensions import Hardware

LUG_WIDTH = 13.0
LUG_NOSE = 6.2
"""Height of a lug's inner face."""


def bump_shield(h: Hardware) -> Part:
    """Return the shield in robot position; it prints as it stands, without support: the lugs' undersides rise at 45 degrees."""
    inner = h.shield_radius - h.shield_wall
    z = (h.shield_bottom, h.shield_top)
    ring = cut(rod(0, 0, z, 2 * h.shield_radius), [rod(0, 0, (z[0] - 1, z[1] + 1), 2 * inner)])
    blank = rod(0, 0, z, 2 * (h.shield_radius - 0.1))
    lugs = [Rot(0, 0, angle) * _lug(h) for angle in (45, 135, 225, 315)]
    solid = joined(ring, [lug & blank for lug in lugs])
    return cut(solid, [*(Rot(0, 0, angle) * hole for angle in (45, 135, 225, 315) for hole in _lug_holes(h)), _charge_window(h)])


def _lug(h: Hardware) -> Part:
    """One lug, pointing along x."""
    outer = h.shield_radius
    nose = h.shield_radius - h.shield_wall - h.lug_reach
    top, low = h.deck_bottom, h.deck_bottom - LUG_NOSE
    profile = [(nose, top), (outer, top), (outer, low - (outer - nose)), (nose, low)]
    return prism_y(profile, (-LUG_WIDTH / 2, LUG_WIDTH / 2))


def _lug_holes(h: Hardware) -> list[Part]:
    top = h.deck_bottom
    nut = (top - 2.2 - h.screws.m3_nut_height - 0.3, top - 2.2)
    half = h.screws.m3_nut / 2
    pocket = block((0.0, h.lug_radius + half / 0.866), (-half, half), nut)
    return [rod(h.lug_radius, 0, (top - 12, top + 1), h.screws.m3), pocket]


def _charge_window(h: Hardware) -> Part:
    width, low, high, radius = h.charge_window
    flat = rounded((low, high), (-width / 2, width / 2), (h.shield_radius - 5, h.shield_radius + 5), radius)
    return Rot(0, -90, 0) * flat

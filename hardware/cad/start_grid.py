"""Start-grid template: rings and bars that mark the world's starting points on the arena's floor."""

from __future__ import annotations

from build123d import Part, Pos, Rot

from hardware.cad.shapes import block, cut, joined, polar, prism, rod
from hardware.dimensions import Hardware

BAND = 6.0
"""Width of the ring."""
BAR = 16.0
"""Width of arms and bars."""
TONGUE = (8.0, 12.0, 7.0)
"""Puzzle joint: width at the neck, at the end, length."""


def template_node(h: Hardware) -> Part:
    """Return the ring for one starting point: trace its inside around the shield, mark the centre, read headings off its notches."""
    z = (0.0, h.template_thickness)
    inner = h.shield_radius + 0.5
    ring = rod(0, 0, z, 2 * (inner + BAND))
    spokes = [block((-inner - 1, inner + 1), (-4, 4), z), block((-4, 4), (-inner - 1, inner + 1), z), rod(0, 0, z, 18.0)]
    arms = [Rot(0, 0, a) * block((inner + 1, h.template_arm), (-BAR / 2, BAR / 2), z) for a in (0, 90, 180, 270)]
    hollow = cut(ring, [rod(0, 0, (-1, 10), 2 * inner)])
    body = joined(hollow, spokes + arms)
    sockets = [Rot(0, 0, a) * Pos(h.template_arm, 0, 0) * _tongue(h, h.print.slide) for a in (0, 90, 180, 270)]
    notches = []
    for angle in range(0, 360, 30):
        x, y = polar(inner, angle)
        notches.append(Pos(x, y, 0) * Rot(0, 0, angle) * prism([(-1, -1.6), (2.2, 0), (-1, 1.6)], (-1, 10)))
    keep = [a for a in range(0, 360, 30) if a % 90]
    marks = [notches[a // 30] for a in keep]
    return cut(body, [rod(0, 0, (-1, 10), 3.0), *sockets, *marks])


def template_link(h: Hardware, length: float) -> Part:
    """Return a bar between two nodes, with a tongue at each end."""
    bar = block((0.0, length), (-BAR / 2, BAR / 2), (0.0, h.template_thickness))
    ends = [Rot(0, 0, 0) * _tongue(h, 0.0), Pos(length, 0, 0) * Rot(0, 0, 180) * _tongue(h, 0.0)]
    return joined(bar, ends)


def template_link_x(h: Hardware) -> Part:
    """Return the bar along the arena's long side."""
    return template_link(h, h.template_links[0])


def template_link_y(h: Hardware) -> Part:
    """Return the bar along the arena's short side."""
    return template_link(h, h.template_links[1])


def _tongue(h: Hardware, gap: float) -> Part:
    """A dovetail that reaches along -x from x = 0."""
    neck, end, reach = TONGUE
    outline = [(0.01, -neck / 2 - gap), (0.01, neck / 2 + gap), (-reach - gap, end / 2 + gap), (-reach - gap, -end / 2 - gap)]
    return prism(outline, (-1.0, 10.0) if gap else (0.0, h.template_thickness))

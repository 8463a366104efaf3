"""Arena walls: straight segments and corners that close the world file's rectangle, joined by dovetails that slide in from above."""

from __future__ import annotations

from build123d import Part, Pos, Rot

from hardware.cad.shapes import Range, block, cut, joined, prism, prism_y, rod
from hardware.dimensions import Hardware

DOVETAIL = (6.0, 9.0, 5.0)
"""Width at the neck, width at the end, length."""
POST = 14.0
"""Width of the thickened end that holds the joint, outside the wall."""


def wall_segment(h: Hardware) -> Part:
    """Return a segment along x with its inner face on y = 0, tongue at the far end; it prints as it stands."""
    length = h.wall_plan[0]
    body = joined(_run(h, (0.0, length)), [_post(h, (0.0, 12.0)), _post(h, (length - 8.0, length)), *_ribs(h, length)])
    body = joined(body, [Pos(length, 0, 0) * _tongue(h, 0.0)])
    return cut(body, [_tongue(h, h.print.slide), *_floor_holes(h, [length / 3, length * 2 / 3])])


def wall_corner(h: Hardware) -> Part:
    """Return a corner whose inner edge is the z axis, the arena at x < 0 < y.

    Walking around the arena with it on the left, one comes in along +x and leaves along +y: a socket at the start, a tongue at the end,
    as a segment has them.
    """
    leg, reach = h.wall_plan[1], h.arena_wall
    coming = joined(_run(h, (-leg, reach)), [_post(h, (-leg, -leg + 12.0)), *(Pos(-leg, 0, 0) * rib for rib in _ribs(h, leg))])
    coming = cut(coming, [Pos(-leg, 0, 0) * _tongue(h, h.print.slide)])
    leaving = joined(_run(h, (-reach, leg)), [_post(h, (leg - 8.0, leg)), *_ribs(h, leg), Pos(leg, 0, 0) * _tongue(h, 0.0)])
    foot = block((0.0, h.arena_foot), (-h.arena_foot, 0.0), (0, h.arena_foot_height))
    arena = block((-300.0, 0.0), (0.0, 300.0), (-1, h.wall_height + 1))
    solid = cut(joined(coming, [Rot(0, 0, 90) * leaving, foot]), [arena])
    holes = _floor_holes(h, [leg / 2])
    return cut(solid, [*(Pos(-leg, 0, 0) * hole for hole in holes), *(Rot(0, 0, 90) * hole for hole in holes)])


def _run(h: Hardware, x: Range) -> Part:
    """Wall and foot; the arena lies at y > 0."""
    wall = block(x, (-h.arena_wall, 0.0), (0, h.wall_height))
    return joined(wall, [block(x, (-h.arena_foot, 0.0), (0, h.arena_foot_height))])


def _post(h: Hardware, x: Range) -> Part:
    return block(x, (-POST, 0.0), (0, h.wall_height))


def _ribs(h: Hardware, length: float) -> list[Part]:
    """Triangular ribs that keep the wall upright when a robot leans on it."""
    count = max(1, round(length / 50))
    profile = [(0.0, 0.0), (h.arena_foot - 2, 0.0), (h.arena_wall, h.wall_height - 8), (0.0, h.wall_height - 8)]
    rib = Rot(0, 0, -90) * prism_y(profile, (-1.2, 1.2))
    return [Pos(length * (i + 0.5) / count, 0, 0) * rib for i in range(count)]


def _tongue(h: Hardware, gap: float) -> Part:
    """The dovetail that reaches along +x from x = 0; ``gap`` widens it into the socket."""
    neck, end, reach = DOVETAIL
    middle = -POST / 2 - 0.5
    outline = [
        (-0.01, middle - neck / 2 - gap),
        (reach + gap, middle - end / 2 - gap),
        (reach + gap, middle + end / 2 + gap),
        (-0.01, middle + neck / 2 + gap),
    ]
    return prism(outline, (-1.0 if gap else 0.0, h.wall_height + (1.0 if gap else 0.0)))


def _floor_holes(h: Hardware, along: list[float]) -> list[Part]:
    """Holes for 3.5 mm wood screws, midway between ribs."""
    return [rod(x, -h.arena_foot + 7.0, (-1, h.arena_foot_height + 1), 4.0) for x in along]

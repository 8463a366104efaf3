"""Hat: the cylinder that other robots' sensors see, with the mount of its own time-of-flight sensor and a flat top for a marker."""

from __future__ import annotations

from build123d import Part, Pos, Rot

from hardware.cad.shapes import block, cut, joined, prism, prism_y, rod
from hardware.dimensions import Hardware

LUG = 8.0
"""Diameter of the feet."""
FOOT = 3.0
"""Plastic under the feet's screw heads."""
PAD = 3.0
"""Thickness of the wall behind the sensor board."""
ENGRAVE = 0.5
"""Depth of the heading arrow in the top."""


def hat(h: Hardware) -> Part:
    """Return the hat in robot position; it prints upside down, top on the bed, without support."""
    outer, top = h.hat_radius, h.hat_top
    shell = rod(0, 0, (h.deck_top, top), 2 * outer)
    room = rod(0, 0, (h.deck_top - 1, top - h.hat_wall), 2 * (outer - h.hat_wall))
    body = joined(cut(shell, [room]), [_sensor_pad(h), *(_foot(h, angle) for angle in h.hat_lug_angles)])
    return cut(body, [*_sensor_recess(h), *_foot_holes(h), *_openings(h), _arrow(h)])


def sensor_place(h: Hardware) -> Pos:
    """Carries the sensor's own frame into the robot's: x along the beam, origin at the middle of the chip's face."""
    return Pos(h.sensor_forward, 0, h.sensor_height) * Rot(0, -h.sensor_tilt, 0)


def board_back(h: Hardware) -> float:
    """The board's rear face in the sensor's frame."""
    return -h.boards.tof_chip[2] - h.boards.tof[2]


def _sensor_pad(h: Hardware) -> Part:
    """Thickens the front wall inwards; 45-degree ends above let it print upside down."""
    half, back = h.boards.tof[0] / 2 + 1.0, board_back(h) - PAD
    low, high = h.sensor_height - 8.5, h.sensor_height + 7.5
    depth = 7.0
    rear = h.sensor_forward + back
    profile = [(rear, low), (h.hat_radius, low), (h.hat_radius, high + depth), (rear + 1.2, high)]
    pad = prism_y(profile, (-half, half))
    return pad & rod(0, 0, (0, h.hat_top), 2 * (h.hat_radius - 0.01))


def _sensor_recess(h: Hardware) -> list[Part]:
    """The board's seat, open to the front, its two screw slots and the opening behind its row of pins."""
    place, (width, height, _) = sensor_place(h), h.boards.tof
    back = board_back(h)
    half, up = width / 2 + 0.4, height / 2 + 0.4
    recess = place * block((back, 30), (-half, half), (-up, up))
    pins = place * block((back - 10, back + 1), (-half + 3.5, half - 3.5), (-up, -up + 3.0))
    screws = []
    for side in (1, -1):
        y = side * h.boards.tof_hole_pitch / 2
        screws.append(place * Pos(0, y, 0) * Rot(0, -90, 0) * rod(0, 0, (-30, 30), h.screws.m25))
    return [recess, pins, *screws]


def _foot(h: Hardware, angle: float) -> Part:
    """A foot outside the shell; its upper side slopes at 45 degrees, which prints upside down."""
    reach = h.hat_lug_radius
    stem = joined(block((h.hat_radius - 1, reach), (-LUG / 2, LUG / 2), (0, 30)), [rod(reach, 0, (0, 30), LUG)])
    slope = prism_y(
        [(0, 0), (reach + LUG, 0), (reach + LUG, FOOT), (h.hat_radius - 1, FOOT + reach + LUG - h.hat_radius + 1), (0, 30)], (-9, 9)
    )
    inside = rod(0, 0, (-1, 40), 2 * (h.hat_radius - 0.5))
    return Rot(0, 0, angle) * Pos(0, 0, h.deck_top) * cut(stem & slope, [inside])


def _foot_holes(h: Hardware) -> list[Part]:
    holes = []
    for angle in h.hat_lug_angles:
        place = Rot(0, 0, angle) * Pos(h.hat_lug_radius, 0, h.deck_top)
        holes.append(place * rod(0, 0, (-1, 20), h.screws.m3))
        holes.append(place * rod(0, 0, (FOOT, 20), h.screws.m3_head))
    return holes


def _openings(h: Hardware) -> list[Part]:
    """Notches over the encoder brackets, the NodeMCU's USB window on the left, vents on the right."""
    notch = block((-18.5, 18.5), (-60, 60), (h.deck_top - 1, h.deck_top + 5.5))
    x, z = h.nodemcu_x, h.deck_top + 5.0 + 1.6 + h.boards.socket_height + 1.6 + 1.5
    usb = block((x - 7.5, x + 7.5), (20, 60), (z - 5.5, z + 5.5))
    vents = [block((x - 1.5, x + 1.5), (-60, -20), (h.deck_top + 12, h.deck_top + 28)) for x in (-10, -4, 2, 8)]
    return [notch, usb, *vents]


def _arrow(h: Hardware) -> Part:
    """The heading, for the eye and for placing the tracking marker."""
    outline = [(36, 0), (30, 4.5), (30, 1), (-34, 1), (-34, -1), (30, -1), (30, -4.5)]
    cross = block((-1, 1), (-34, 34), (h.hat_top - ENGRAVE, h.hat_top + 1))
    return joined(prism(outline, (h.hat_top - ENGRAVE, h.hat_top + 1)), [cross])

"""Body plate: pocket and pillars for two SG90 servos, bosses for the standoffs, the battery tray's two screws."""

from __future__ import annotations

from build123d import Part

from hardware.cad.shapes import block, cut, four, hexagon, joined, rod, rod_y
from hardware.dimensions import Hardware

WIRE_SLOT = ((-23.5, -18.5), (-7.0, 7.0))
"""Opening for the cell's leads, x and y bounds."""
SKID_NUT = 1.0
"""Depth of the pockets that keep the skids' nuts from turning."""


def body_plate(h: Hardware) -> Part:
    """Return the plate in robot position; it prints as it stands, pillars upwards, without support."""
    return cut(_stock(h), [*_servo_room(h), *_holes(h)])


def servo_span(h: Hardware) -> tuple[float, float]:
    """Bounds along x of the servos' cases: the shaft stands at x = 0, the case reaches backwards."""
    return h.servo.shaft_from_end - h.servo.length, h.servo.shaft_from_end


def flange_span(h: Hardware) -> tuple[float, float]:
    """Bounds along x of the servos' flanges."""
    low, high = servo_span(h)
    extra = (h.servo.flange_length - h.servo.length) / 2
    return low - extra, high + extra


def pillar_y(h: Hardware) -> tuple[float, float]:
    """Bounds along y of the left servo's pillars: the flange is screwed against their outer faces."""
    outer = h.servo_back_gap + h.servo.flange_bottom
    return outer - h.pillar_thickness, outer


def pillar_x(h: Hardware) -> tuple[tuple[float, float], tuple[float, float]]:
    """Bounds along x of the rear and of the front pillars."""
    low, high = servo_span(h)
    play = h.servo.play_length
    return (low - play - 7.3, low - play), (high + play, high + play + 9.7)


def tray_screws(h: Hardware) -> list[tuple[float, float]]:
    """Where the power tray is screwed to the pillars: (x, y)."""
    y = sum(pillar_y(h)) / 2
    return [(x, side * y) for x in (-21.3, 13.2) for side in (1, -1)]


def servo_screws(h: Hardware) -> list[float]:
    """Heights above and below aside, the x of a servo's two flange screws."""
    middle = sum(servo_span(h)) / 2
    return [middle - h.servo.hole_pitch / 2, middle + h.servo.hole_pitch / 2]


def _stock(h: Hardware) -> Part:
    plate = rod(0, 0, (h.plate_bottom, h.plate_top), h.chassis_diameter)
    flat = h.wheel_inner - h.wheel_gap
    plate = plate & block((-50, 50), (-flat, flat), (0, 50))
    bosses = [rod(x, y, (h.plate_top, h.plate_top + h.boss_height), 7.0) for x, y in four(*h.standoff_xy)]
    low, high = pillar_y(h)
    pillars = [
        block(span, sorted_range(side * low, side * high), (h.plate_bottom + h.seat_floor, h.pillar_top))
        for span in pillar_x(h)
        for side in (1, -1)
    ]
    return joined(plate, bosses + pillars)


def sorted_range(a: float, b: float) -> tuple[float, float]:
    """Return the two bounds in order."""
    return (a, b) if a < b else (b, a)


def _servo_room(h: Hardware) -> list[Part]:
    """The pocket that both cases share and, deeper along x, the room of the flanges."""
    low, high = servo_span(h)
    seat = h.plate_bottom + h.seat_floor
    case = h.servo_back_gap + h.servo.case + 0.3
    room = [block((low - h.servo.play_length, high + h.servo.play_length), (-case, case), (seat, h.pillar_top + 1))]
    low, high = flange_span(h)
    inner = h.servo_back_gap + h.servo.flange_bottom
    outer = inner + h.servo.flange_height + 0.4
    for side in (1, -1):
        room.append(block((low - 0.5, high + 0.5), sorted_range(side * inner, side * outer), (seat, h.plate_top + 1)))
        # the round gear housing and the wheel's horn reach below the plate's upper side
        room.append(rod_y(0, h.axle_height, sorted_range(side * (case - 1), side * 40), h.servo.turret_diameter + 0.6))
    return room


def _holes(h: Hardware) -> list[Part]:
    through = (h.plate_bottom - 1, h.plate_top + h.boss_height + 1)
    holes = []
    for x, y in four(*h.standoff_xy):
        holes.append(rod(x, y, through, h.screws.m3))
        holes.append(rod(x, y, (h.plate_bottom - 1, h.plate_bottom + h.screws.m3_head_height), h.screws.m3_head))
    for x in (-h.skid_x, h.skid_x):
        holes.append(rod(x, 0, through, h.screws.m3))
        holes.append(hexagon(x, 0, (h.plate_top - SKID_NUT, h.plate_top + 1), h.screws.m3_nut))
    low, high = pillar_y(h)
    for x in servo_screws(h):
        holes += [rod_y(x, h.axle_height, sorted_range(side * (low - 1), side * (high + 1)), h.screws.m2_pilot) for side in (1, -1)]
    holes += [rod(x, y, (h.pillar_top - 5, h.pillar_top + 1), h.screws.m2_pilot) for x, y in tray_screws(h)]
    holes.append(block(*WIRE_SLOT, through))
    return holes

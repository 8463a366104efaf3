"""Bought parts as outlines: enough to see that they fit, never a maker's drawing."""

from __future__ import annotations

from build123d import Part, Pos, Rot

from hardware.cad.body_plate import flange_span, servo_screws, servo_span
from hardware.cad.encoder_bracket import ear_holes
from hardware.cad.power_tray import charger_span, converter_span
from hardware.cad.shapes import block, cut, hexagon, joined, polar, prism, rod, rod_y, rounded, torus_y
from hardware.dimensions import Hardware


def servo(h: Hardware) -> Part:
    """Return the left servo's housing: shaft along +y, case reaching backwards."""
    s, base, z = h.servo, h.servo_back_gap, h.axle_height
    low, high = z - s.width / 2, z + s.width / 2
    case = block(servo_span(h), (base, base + s.case), (low, high))
    flange = block(flange_span(h), (base + s.flange_bottom, base + s.flange_bottom + s.flange_height), (low, high))
    turret = rod_y(0, z, (base + s.case, base + s.turret), s.turret_diameter)
    holes = [rod_y(x, z, (base + s.flange_bottom - 1, base + s.flange_bottom + s.flange_height + 1), 2.2) for x in servo_screws(h)]
    return cut(joined(case, [flange, turret]), holes)


def output_shaft(h: Hardware) -> Part:
    """Return the left servo's output shaft above its housing."""
    return rod_y(0, h.axle_height, (h.servo_back_gap + h.servo.turret, h.servo_back_gap + h.servo.overall), h.servo.spline_diameter)


def horn(h: Hardware) -> Part:
    """Return the left wheel's double-arm horn."""
    n, outer = h.horn, h.horn_outer
    hub = rod_y(0, h.axle_height, (outer - n.height, outer), n.hub_diameter)
    reach, wide, narrow = n.arm_span / 2, n.arm_width_hub / 2, n.arm_width_tip / 2
    outline = [(-reach, -narrow), (0, -wide), (reach, -narrow), (reach, narrow), (0, wide), (-reach, narrow)]
    arms = Pos(0, 0, h.axle_height) * Rot(90, 0, 0) * prism(outline, (-outer, -outer + n.arm_thickness))
    screw = rod_y(0, h.axle_height, (0, outer + 1), 2.2)
    return cut(joined(hub, [arms]), [output_shaft(h), screw])


def tire(h: Hardware) -> Part:
    """Return the left wheel's O-ring, stretched into its groove."""
    section = h.mounted_tire_section
    return torus_y(h.axle_height, h.wheel_base / 2, h.groove_diameter / 2 + section / 2, section / 2)


def optical_switch(h: Hardware) -> Part:
    """Return the left slotted switch, base up, gap down over the disc."""
    s, y, z = h.switch, h.disc_y, h.switch_base
    body = block((-s.width / 2, s.width / 2), (y - s.body / 2, y + s.body / 2), (z - s.height, z))
    ears = block((-s.width / 2, s.width / 2), (y - s.length / 2, y + s.length / 2), (z - s.ear_height, z))
    gap = block((-s.width, s.width), (y - s.gap / 2, y + s.gap / 2), (z - s.height - 1, z - s.gap_floor))
    pins = [
        block((x - 0.25, x + 0.25), (y + side * s.pin_pitch_length / 2 - 0.25, y + side * s.pin_pitch_length / 2 + 0.25), (z, z + 7))
        for side in (1, -1)
        for x in (-s.pin_pitch_width / 2, s.pin_pitch_width / 2)
    ]
    holes = [rod(0, e, (z - s.ear_height - 1, z + 1), s.hole) for e in ear_holes(h)]
    return joined(cut(joined(body, [ears]), [gap, *holes]), pins)


def cell(h: Hardware) -> Part:
    """Return the pouch cell on the floor of its tray, on 0.3 mm of foam."""
    x, y, z = h.boards.cell
    base = h.tray_floor + h.print.wall + 0.3
    return rounded((-x / 2, x / 2), (-y / 2, y / 2), (base, base + z), 2.0)


def charger(h: Hardware) -> Part:
    """Return the TP4056 board, its socket looking backwards."""
    _, width, height = h.boards.charger
    low, high = charger_span(h)
    base = h.pillar_top + h.tray_thickness
    board = block((low, high), (-width / 2, width / 2), (base, base + 1.2))
    socket = block((low - 0.8, low + 6.5), (-4.5, 4.5), (base + 1.2, base + height))
    chips = block((low + 10, low + 20), (-5, 5), (base + 1.2, base + 2.9))
    return joined(board, [socket, chips])


def converter(h: Hardware) -> Part:
    """Return the MT3608 board, lying across."""
    length, _, height = h.boards.converter
    low, high = converter_span(h)
    base = h.pillar_top + h.tray_thickness
    board = block((low, high), (-length / 2, length / 2), (base, base + 1.4))
    coil = block((low + 5, low + 13), (-2, 6), (base + 1.4, base + height))
    trimmer = block((low + 3.5, low + 13.0), (-13, -6), (base + 1.4, base + height))
    return joined(board, [coil, trimmer])


def standoff(h: Hardware, x: float, y: float) -> Part:
    """Return a hexagonal M3 standoff between body plate and deck."""
    z = (h.deck_bottom - h.standoff, h.deck_bottom)
    return cut(hexagon(x, y, z, 5.5), [rod(x, y, (z[0] - 1, z[1] + 1), 3.0)])


def carrier(h: Hardware) -> Part:
    """Return the carrier board with the 74HC14 and the connectors under and beside the NodeMCU's sockets."""
    along, across, thick = h.boards.carrier
    base = h.deck_top + 5.0
    board = block((-across / 2, across / 2), (-along / 2, along / 2), (base, base + thick))
    hx, hy = h.boards.carrier_holes[1] / 2, h.boards.carrier_holes[0] / 2
    board = cut(board, [rod(x, y, (base - 1, base + thick + 1), 2.3) for x in (-hx, hx) for y in (-hy, hy)])
    top = base + thick
    x = h.nodemcu_x
    rows = [block((x + s * 11.43 - 1.25, x + s * 11.43 + 1.25), (-19.1, 19.1), (top, top + h.boards.socket_height)) for s in (1, -1)]
    chip = block((x - 4, x + 4), (-10, 9), (top, top + 4.5))
    plugs = [block((12.5, 18.0), (y - 5, y + 5), (top, top + 6)) for y in (-18, -6, 6, 18)]
    return joined(board, [*rows, chip, *plugs])


def nodemcu(h: Hardware) -> Part:
    """Return the NodeMCU in its sockets, USB to the left."""
    along, across, thick = h.boards.nodemcu
    base = h.deck_top + 5.0 + h.boards.carrier[2] + h.boards.socket_height
    x = h.nodemcu_x
    board = block((x - across / 2, x + across / 2), (-along / 2, along / 2), (base, base + thick))
    can = block((x - 7.5, x + 7.5), (-along / 2 + 6, -along / 2 + 21), (base + thick, base + thick + 2.6))
    usb = block((x - 3.9, x + 3.9), (along / 2 - 5, along / 2 + 0.6), (base + thick, base + thick + 2.8))
    return joined(board, [can, usb])


def tof(h: Hardware) -> Part:
    """Return the VL53L1X breakout in the hat's seat."""
    from hardware.cad.hat import board_back, sensor_place

    width, height, thick = h.boards.tof
    back = board_back(h)
    board = block((back, back + thick), (-width / 2, width / 2), (-height / 2, height / 2))
    holes = [Pos(0, s * h.boards.tof_hole_pitch / 2, 0) * Rot(0, -90, 0) * rod(0, 0, (-30, 30), 3.0) for s in (1, -1)]
    chip_width, chip_height, chip = h.boards.tof_chip
    face = block((-chip, 0.0), (-chip_width / 2, chip_width / 2), (-chip_height / 2, chip_height / 2))
    return sensor_place(h) * joined(cut(board, holes), [face])


def rocker(h: Hardware) -> Part:
    """Return the power switch in the deck."""
    across, along = h.boards.rocker[1], h.boards.rocker[0]
    x, y = polar(h.rocker_radius, h.rocker_angle)
    body = block((-across / 2 + 0.2, across / 2 - 0.2), (-along / 2 + 0.2, along / 2 - 0.2), (h.deck_bottom - 8.0, h.deck_top))
    frame = block((-5.2, 5.2), (-7.5, 7.5), (h.deck_top, h.deck_top + 1.8))
    key = block((-3.0, 3.0), (-5.5, 5.5), (h.deck_top + 1.8, h.deck_top + 3.6))
    legs = [block((-2.4, 2.4), (s * 4 - 0.4, s * 4 + 0.4), (h.deck_bottom - 14.0, h.deck_bottom - 8.0)) for s in (1, -1)]
    return Pos(x, y, 0) * Rot(0, 0, h.rocker_angle) * joined(body, [frame, key, *legs])


def screw(length: float, diameter: float = 3.0, head: float = 5.6, head_height: float = 2.4) -> Part:
    """Return a screw, head upwards: its head rests on z = 0, the shank points down."""
    return joined(rod(0, 0, (-length, 0.0), diameter), [rod(0, 0, (0.0, head_height), head)])


def nut(flats: float = 5.5, height: float = 2.4, bore: float = 3.0) -> Part:
    """Return a nut from z = 0 upwards."""
    return cut(hexagon(0, 0, (0.0, height), flats), [rod(0, 0, (-1, height + 1), bore)])

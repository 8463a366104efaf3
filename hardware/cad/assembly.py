"""The whole robot: every part and every screw in its place, with the step of the assembly in which it is added."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from build123d import Color, Compound, Part, Plane, Pos, Rot, mirror

from hardware.cad import bought
from hardware.cad.battery_tray import battery_tray, front_skid, rear_skid
from hardware.cad.body_plate import SKID_NUT, body_plate, servo_screws, tray_screws
from hardware.cad.bump_shield import bump_shield
from hardware.cad.deck import ballast_posts, carrier_posts, deck, hat_screws, shield_screws
from hardware.cad.encoder_bracket import PLATE, WING_SCREW, ear_holes, encoder_bracket
from hardware.cad.encoder_disc import encoder_disc
from hardware.cad.hat import FOOT, PAD, board_back, hat, sensor_place
from hardware.cad.power_tray import power_tray
from hardware.cad.shapes import four
from hardware.cad.wheel import DISC_SCREW_RADIUS, wheel
from hardware.dimensions import Hardware

PRINTED, BOUGHT, METAL, RUBBER, BOARD, CELL = "printed", "bought", "metal", "rubber", "board", "cell"
COLOURS = {
    PRINTED: (0.90, 0.62, 0.10),
    BOUGHT: (0.25, 0.30, 0.36),
    METAL: (0.72, 0.74, 0.76),
    RUBBER: (0.12, 0.12, 0.12),
    BOARD: (0.00, 0.45, 0.55),
    CELL: (0.80, 0.82, 0.86),
}
"""Colour of each kind in pictures and STEP, distinct for colour-blind readers (red, green, blue from 0 to 1)."""
SHIELD_COLOUR = (0.34, 0.60, 0.85)

Moves = tuple[float, float, float]


@dataclass(frozen=True)
class Item:
    """One piece of the robot.

    Attributes:
        name: Its label, unique in the robot.
        solid: Its shape in robot position.
        kind: A key of ``COLOURS``.
        step: The step of ``docs/assembly.md`` that adds it.
        explode: Where the exploded view moves it, mm.
        turns: Whether it turns with a wheel.
        screwed: Names of the items it cuts its own thread into, or whose modelled thread it fills.
    """

    name: str
    solid: Part
    kind: str
    step: int
    explode: Moves
    turns: bool = False
    screwed: tuple[str, ...] = ()

    @property
    def colour(self) -> tuple[float, float, float]:
        """Its colour in pictures."""
        return SHIELD_COLOUR if self.name == "bump shield" else COLOURS[self.kind]


def robot(h: Hardware) -> list[Item]:
    """Return every piece of one robot, in order of assembly."""
    return [*_drive(h), *_power(h), *_deck(h), *_encoders(h), *_carrier(h), *_battery(h), *_top(h)]


def compound(items: list[Item]) -> Compound:
    """Return the assembly as one labelled, coloured tree for STEP."""
    children = []
    for item in items:
        child = Pos(0, 0, 0) * item.solid
        child.label, child.color = item.name, Color(*item.colour)
        children.append(child)
    return Compound(label="hero_plus", children=children)


def both_sides(make: Callable[[], Part]) -> list[tuple[str, Part, int]]:
    """Return a left piece and its mirror image: side, solid, sign of y."""
    left = make()
    return [("left", left, 1), ("right", mirror(left, about=Plane.XZ), -1)]


def _drive(h: Hardware) -> list[Item]:
    items = [Item("body plate", body_plate(h), PRINTED, 1, (0, 0, -40))]
    for side, solid, sign in both_sides(lambda: bought.servo(h)):
        items.append(Item(f"servo {side}", solid, BOUGHT, 1, (0, 22 * sign, -10)))
        shaft = bought.output_shaft(h)
        if sign < 0:
            shaft = mirror(shaft, about=Plane.XZ)
        items.append(Item(f"output shaft {side}", shaft, BOUGHT, 1, (0, 22 * sign, -10), turns=True))
        flange = h.servo_back_gap + h.servo.flange_bottom + h.servo.flange_height
        for index, x in enumerate(servo_screws(h)):
            place = Pos(x, sign * flange, h.axle_height) * Rot(-90 * sign, 0, 0)
            name = f"servo screw {side} {index + 1}"
            shape = place * bought.screw(6.0, 2.0, 3.6, 1.4)
            items.append(Item(name, shape, METAL, 1, (0, 45 * sign, -10), screwed=("body plate",)))
    return items


def _power(h: Hardware) -> list[Item]:
    items = []
    items.append(Item("power tray", power_tray(h), PRINTED, 2, (0, 0, 14)))
    for index, (x, y) in enumerate(tray_screws(h)):
        place = Pos(x, y, h.pillar_top + h.tray_thickness)
        shape = place * bought.screw(6.0, 2.0, 3.6, 1.4)
        items.append(Item(f"power tray screw {index + 1}", shape, METAL, 2, (0, 0, 40), screwed=("body plate",)))
    items.append(Item("charger", bought.charger(h), BOARD, 2, (0, 0, 30)))
    items.append(Item("boost converter", bought.converter(h), BOARD, 2, (0, 0, 30)))
    return items


def _battery(h: Hardware) -> list[Item]:
    items = [
        Item("battery tray", battery_tray(h), PRINTED, 8, (0, 0, -110)),
        Item("cell", bought.cell(h), CELL, 8, (0, 0, -82)),
    ]
    for name, solid, x, bottom in (
        ("front skid", front_skid(h), h.skid_x, h.front_skid_lift),
        ("rear skid", rear_skid(h), -h.skid_x, 0.0),
    ):
        items.append(Item(name, solid, PRINTED, 8, (0, 0, -122)))
        head = Pos(x, 0, bottom + h.skid_head) * Rot(180, 0, 0) * bought.screw(20.0, head=5.7, head_height=1.65)
        items.append(Item(f"{name} screw", head, METAL, 8, (0, 0, -134), screwed=(f"{name} nut",)))
        items.append(Item(f"{name} nut", Pos(x, 0, h.plate_top - SKID_NUT) * bought.nut(), METAL, 8, (0, 0, -30)))
    return items


def _deck(h: Hardware) -> list[Item]:
    items = [Item("deck", deck(h), PRINTED, 4, (0, 0, 90))]
    for index, (x, y) in enumerate(four(*h.standoff_xy)):
        name = f"standoff {index + 1}"
        items.append(Item(name, bought.standoff(h, x, y), METAL, 3, (0, 0, 52)))
        below = Pos(x, y, h.plate_bottom + h.screws.m3_head_height) * Rot(180, 0, 0) * bought.screw(8.0)
        items.append(Item(f"standoff screw {index + 1}", below, METAL, 3, (0, 0, -58), screwed=(name,)))
        above = Pos(x, y, h.deck_top) * bought.screw(6.0)
        items.append(Item(f"deck screw {index + 1}", above, METAL, 4, (0, 0, 112), screwed=(name,)))
    for index, (x, y) in enumerate(ballast_posts(h)):
        place = Pos(x, y, h.deck_top) * Rot(0, 0, h.ballast_angles[index])
        items.append(Item(f"ballast {index + 1}", place * bought.nut(13.0, 6.5, h.ballast_post), METAL, 4, (0, 0, 112)))
    items.append(Item("power switch", bought.rocker(h), BOUGHT, 4, (0, 0, 112)))
    return items


def _encoders(h: Hardware) -> list[Item]:
    items = []
    for side, solid, sign in both_sides(lambda: wheel(h)):
        items.append(Item(f"wheel {side}", solid, PRINTED, 5, (0, 52 * sign, 0), turns=True))
    for side, solid, sign in both_sides(lambda: bought.horn(h)):
        items.append(Item(f"horn {side}", solid, BOUGHT, 5, (0, 38 * sign, 0), turns=True))
    for side, solid, sign in both_sides(lambda: bought.tire(h)):
        items.append(Item(f"O-ring {side}", solid, RUBBER, 5, (0, 64 * sign, 0), turns=True))
    for side, solid, sign in both_sides(lambda: encoder_disc(h)):
        name = f"encoder disc {side}"
        items.append(Item(name, solid, PRINTED, 5, (0, 84 * sign, 0), turns=True))
        face = h.disc_y + h.disc_thickness / 2
        for index, up in enumerate((1, -1)):
            place = Pos(0, sign * face, h.axle_height + up * DISC_SCREW_RADIUS) * Rot(-90 * sign, 0, 0)
            shape = place * bought.screw(6.0, 2.0, 3.6, 1.4)
            items.append(Item(f"{name} screw {index + 1}", shape, METAL, 5, (0, 96 * sign, 0), True, (f"wheel {side}",)))
    for side, solid, sign in both_sides(lambda: encoder_bracket(h)):
        items.append(Item(f"encoder bracket {side}", solid, PRINTED, 6, (0, 34 * sign, 112)))
        items += _bracket_screws(h, side, sign)
    for side, solid, sign in both_sides(lambda: bought.optical_switch(h)):
        items.append(Item(f"optical switch {side}", solid, BOUGHT, 6, (0, 34 * sign, 74)))
    return items


def _bracket_screws(h: Hardware, side: str, sign: int) -> list[Item]:
    items, top = [], h.deck_top + PLATE
    y, name = sign * ear_holes(h)[1], f"switch nut {side}"
    place = Pos(0, y, h.switch_base - h.switch.ear_height) * Rot(180, 0, 0)
    items.append(Item(f"switch screw {side}", place * bought.screw(8.0), METAL, 6, (0, 34 * sign, 60), screwed=(name,)))
    items.append(Item(name, Pos(0, y, top - h.screws.m3_nut_height) * bought.nut(), METAL, 6, (0, 34 * sign, 124)))
    for index, x in enumerate((WING_SCREW[0], -WING_SCREW[0])):
        name = f"bracket nut {side} {index + 1}"
        place = Pos(x, sign * WING_SCREW[1], top) * bought.screw(8.0)
        items.append(Item(f"bracket screw {side} {index + 1}", place, METAL, 6, (0, 34 * sign, 124), screwed=(name,)))
        items.append(Item(name, Pos(x, sign * WING_SCREW[1], h.deck_bottom + 1.2 - 2.4) * bought.nut(), METAL, 6, (0, 0, 70)))
    return items


def _carrier(h: Hardware) -> list[Item]:
    items = [
        Item("carrier board", bought.carrier(h), BOARD, 7, (0, 0, 128)),
        Item("NodeMCU", bought.nodemcu(h), BOARD, 7, (0, 0, 150)),
    ]
    for index, (x, y) in enumerate(carrier_posts(h)):
        place = Pos(x, y, h.deck_top + 5.0 + h.boards.carrier[2])
        shape = place * bought.screw(6.0, 2.0, 3.6, 1.4)
        items.append(Item(f"carrier screw {index + 1}", shape, METAL, 7, (0, 0, 140), screwed=("deck",)))
    return items


def _top(h: Hardware) -> list[Item]:
    items = [Item("bump shield", bump_shield(h), PRINTED, 9, (0, 0, -195))]
    for index, (x, y) in enumerate(shield_screws(h)):
        name, top = f"shield nut {index + 1}", h.deck_bottom
        items.append(Item(f"shield screw {index + 1}", Pos(x, y, h.deck_top) * bought.screw(10.0), METAL, 9, (0, 0, 112), screwed=(name,)))
        turn = Rot(0, 0, 45 + 90 * index)
        items.append(Item(name, Pos(x, y, top - 2.3 - h.screws.m3_nut_height) * turn * bought.nut(), METAL, 9, (0, 0, -195)))
    items.append(Item("hat", hat(h), PRINTED, 10, (0, 0, 185)))
    for index, (x, y) in enumerate(hat_screws(h)):
        name = f"hat nut {index + 1}"
        items.append(
            Item(f"hat screw {index + 1}", Pos(x, y, h.deck_top + FOOT) * bought.screw(8.0), METAL, 10, (0, 0, 185), screwed=(name,))
        )
        items.append(Item(name, Pos(x, y, h.deck_bottom + 1.2 - 2.4) * bought.nut(), METAL, 10, (0, 0, 70)))
    items.append(Item("ToF sensor", bought.tof(h), BOARD, 10, (34, 0, 185)))
    for index, sign in enumerate((1, -1)):
        name, y = f"ToF nut {index + 1}", sign * h.boards.tof_hole_pitch / 2
        face = sensor_place(h) * Pos(board_back(h) + h.boards.tof[2], y, 0) * Rot(0, 90, 0)
        items.append(Item(f"ToF screw {index + 1}", face * bought.screw(8.0, 2.5, 4.5, 1.2), METAL, 10, (50, 0, 185), screwed=(name,)))
        rear = sensor_place(h) * Pos(board_back(h) - PAD - 2.2, y, 0) * Rot(0, 90, 0)
        items.append(Item(name, rear * bought.nut(5.0, 2.0, 2.5), METAL, 10, (0, 0, 185)))
    return items

"""The printed parts: how many, how they lie on the bed, and in what."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from build123d import Part, Pos, Rot

from hardware.cad.arena import wall_corner, wall_segment
from hardware.cad.battery_tray import battery_tray, front_skid, rear_skid
from hardware.cad.body_plate import body_plate
from hardware.cad.bump_shield import bump_shield
from hardware.cad.deck import deck
from hardware.cad.encoder_bracket import encoder_bracket
from hardware.cad.encoder_disc import encoder_disc
from hardware.cad.hat import hat
from hardware.cad.power_tray import power_tray
from hardware.cad.start_grid import template_link_x, template_link_y, template_node
from hardware.cad.wheel import wheel
from hardware.dimensions import Hardware


@dataclass(frozen=True)
class Printed:
    """A part to print.

    Attributes:
        name: File name of its STEP, STL and picture.
        build: Makes it in robot position.
        turn: Turns about x, y, z (degrees) that lay it on the bed.
        per_robot: Pieces in one robot; 0 for parts of the arena.
        per_arena: Pieces for the world's whole arena; the grid's template: for one cell of it.
    """

    name: str
    build: Callable[[Hardware], Part]
    turn: tuple[float, float, float] = (0.0, 0.0, 0.0)
    per_robot: int = 0
    per_arena: int = 0

    def on_bed(self, h: Hardware) -> Part:
        """Return the part as it prints: lowest point at z = 0, centred on the bed."""
        solid = Rot(*self.turn) * self.build(h)
        box = solid.bounding_box()
        return Pos(-(box.min.X + box.max.X) / 2, -(box.min.Y + box.max.Y) / 2, -box.min.Z) * solid


def printed_parts(h: Hardware) -> list[Printed]:
    """Return every printed part of a robot and of the arena."""
    _, _, long, short = h.wall_plan
    return [
        Printed("body_plate", body_plate, per_robot=1),
        Printed("battery_tray", battery_tray, per_robot=1),
        Printed("rear_skid", rear_skid, (180.0, 0.0, 0.0), per_robot=1),
        Printed("front_skid", front_skid, (180.0, 0.0, 0.0), per_robot=1),
        Printed("power_tray", power_tray, per_robot=1),
        Printed("deck", deck, per_robot=1),
        Printed("wheel", wheel, (90.0, 0.0, 0.0), per_robot=2),
        Printed("encoder_disc", encoder_disc, (-90.0, 0.0, 0.0), per_robot=2),
        Printed("encoder_bracket", encoder_bracket, (180.0, 0.0, 0.0), per_robot=2),
        Printed("bump_shield", bump_shield, per_robot=1),
        Printed("hat", hat, (180.0, 0.0, 0.0), per_robot=1),
        Printed("wall_segment", wall_segment, per_arena=2 * (long + short)),
        Printed("wall_corner", wall_corner, per_arena=4),
        Printed("template_node", template_node, per_arena=4),
        Printed("template_link_x", template_link_x, per_arena=2),
        Printed("template_link_y", template_link_y, per_arena=2),
    ]

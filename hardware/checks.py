"""Does the design hold together? Each check is a sentence, a verdict and the numbers behind it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hardware.cad.assembly import BOARD, BOUGHT, CELL, METAL, PRINTED, RUBBER, Item
from hardware.cad.catalogue import Printed
from hardware.dimensions import BED, Hardware
from swarm_envs.worlds import WorldSpec

TOUCH = 0.01
"""Two bodies interfere when they share more than this volume, mm³ (faces that touch share numerical dust)."""
THREAD = 10.0
"""Most that a screw may share with what it cuts its thread into, mm³: a 2 mm screw, 6 mm deep in a 1.6 mm hole, takes 7."""
DENSITY = {PRINTED: 1.24e-3, METAL: 7.85e-3, RUBBER: 1.2e-3}
"""g/mm³: PLA printed solid, steel, nitrile rubber."""
MASSES = {
    "servo": 9.0,
    "cell": 36.0,
    "charger": 2.5,
    "boost converter": 4.0,
    "power switch": 1.8,
    "horn": 0.4,
    "output shaft": 0.2,
    "optical switch": 1.3,
    "carrier board": 16.0,
    "NodeMCU": 9.0,
    "ToF sensor": 1.5,
    "standoff": 0.6,
}
"""Typical masses of bought parts in g, to be replaced by weighed ones; standoffs are nylon, the carrier comes with its parts and wires."""


@dataclass(frozen=True)
class Check:
    """A claim about the design.

    Attributes:
        claim: What should hold.
        passed: Whether it does.
        detail: The numbers.
    """

    claim: str
    passed: bool
    detail: str


@dataclass(frozen=True)
class Pair:
    """Two pieces whose bounding boxes overlap.

    Attributes:
        first: Name of one.
        second: Name of the other.
        volume: What they share, mm³.
        thread: Whether one is a screw in the other's thread.
    """

    first: str
    second: str
    volume: float
    thread: bool

    @property
    def passed(self) -> bool:
        """Nothing shared, or no more than a thread."""
        return self.volume <= (THREAD if self.thread else TOUCH)


def part_checks(part: Printed, solid: Any, stl: Path) -> list[Check]:
    """Check a printed part as it lies on the bed, and the STL written of it."""
    import trimesh

    box = solid.bounding_box()
    size = (box.size.X, box.size.Y, box.size.Z)
    mesh = trimesh.load_mesh(stl)
    pieces = len(solid.solids())
    return [
        Check(f"{part.name}: one valid solid", bool(solid.is_valid) and pieces == 1, f"{pieces} solid, {solid.volume / 1000:.2f} cm³"),
        Check(
            f"{part.name}: its STL is watertight",
            bool(mesh.is_watertight and mesh.is_winding_consistent) and math.isclose(mesh.volume, solid.volume, rel_tol=0.01),
            f"{len(mesh.faces)} triangles, {mesh.volume / 1000:.2f} cm³",
        ),
        Check(f"{part.name}: fits the bed", max(size) <= BED, f"{size[0]:.1f} x {size[1]:.1f} x {size[2]:.1f} mm on {BED:g} x {BED:g}"),
    ]


def agreement_checks(h: Hardware, world: WorldSpec, items: Sequence[Item]) -> list[Check]:
    """Measure the solids and compare them with the robot file and the world file."""
    by_name = {item.name: item for item in items}

    def bounds(name: str) -> Any:
        return by_name[name].solid.bounding_box()

    tire, shield, hat = bounds("O-ring left"), bounds("bump shield"), bounds("hat")
    middles = [(bounds(f"O-ring {side}").min.Y + bounds(f"O-ring {side}").max.Y) / 2 for side in ("left", "right")]
    sensor, sensor_height = _sensor_face(by_name["ToF sensor"].solid)
    contact = 1000 * world.robots[0].body.contact_radius
    edges = encoder_edges(h, by_name["encoder disc left"].solid)
    return [
        _same("wheel: diameter over the O-ring is the firmware's", tire.size.Z, h.wheel_diameter),
        _same("wheel: it stands on the floor", tire.min.Z, 0.0),
        _same("wheel: base between the O-rings is the world's", middles[0] - middles[1], 1000 * world.robots[0].drive.wheel_base),
        _same("chassis: the body plate keeps HeRo's diameter", bounds("body plate").size.X, h.chassis_diameter),
        _same("encoder: edges per turn on the printed disc are the firmware's ticks", float(edges), float(h.encoder_ticks)),
        _same("shield: outer radius is the robot file's", shield.max.X, h.shield_radius),
        _same("shield: height is the robot file's", shield.size.Z, h.shield_height),
        Check(
            "shield: lies inside the world's contact radius, which is the authors' rounder figure",
            0.0 <= contact - shield.max.X <= 2.5,
            f"{shield.max.X:.1f} mm printed, {contact:.1f} mm simulated",
        ),
        Check(
            "hat: its radius is the world's visible radius",
            abs(hat_radius(by_name["hat"].solid, h) - 1000 * world.robots[0].body.visible_radius) < 0.05,
            f"{hat_radius(by_name['hat'].solid, h):.2f} mm",
        ),
        _same("hat: top is the robot file's", hat.max.Z, h.hat_top),
        _same("sensor: height of the chip's face is the robot file's", sensor_height, h.sensor_height),
        _same("sensor: its face is as far ahead of the axle as the robot file says", sensor, h.sensor_forward),
    ]


def _same(claim: str, measured: float, wanted: float, tolerance: float = 0.05) -> Check:
    return Check(claim, abs(measured - wanted) <= tolerance, f"measured {measured:.3f}, wanted {wanted:.3f}")


def _sensor_face(solid: Any) -> tuple[float, float]:
    """Forward position and height of the middle of the sensor's foremost face."""
    middle = max((face.center() for face in solid.faces()), key=lambda point: point.X)
    return float(middle.X), float(middle.Z)


def hat_radius(solid: Any, h: Hardware) -> float:
    """Radius of the hat above its feet, measured on the solid's upper edge."""
    top = [edge for edge in solid.edges() if abs(edge.center().Z - h.hat_top) < 1e-6 and edge.length > 100]
    return max(edge.length for edge in top) / (2 * math.pi) if top else math.nan


def encoder_edges(h: Hardware, solid: Any) -> int:
    """Count the light's changes in one turn of the left disc: twice the teeth that a circle along the track runs through."""
    from build123d import Edge, Plane

    # the circle starts in the middle of a slot, so that its seam splits no tooth
    track = Edge.make_circle(h.track_radius, Plane(origin=(0, h.disc_y, h.axle_height), x_dir=(1, 0, 0), z_dir=(0, -1, 0)))
    return 2 * len((track & solid).edges())


def sensor_checks(h: Hardware, items: Sequence[Item]) -> list[Check]:
    """Does the beam pass over the wall, and over the robot's own shield?"""
    segments = []
    for name, half in (("region of 4 x 4", h.sensor_cone), ("full view of 27 degrees", 13.5)):
        cone = sensor_cone(h, half, 120.0)
        worst, volume = most_in_the_way(cone, [item for item in items if item.name != "ToF sensor"])
        segments.append(Check(f"sensor: the {name} sees nothing of its own robot", volume <= TOUCH, f"most: {worst}, {volume:.3f} mm³"))
    return [
        Check("sensor: above the wall", h.sensor_height > h.wall_height, f"{h.sensor_height:g} mm over a wall of {h.wall_height:g} mm"),
        Check(
            "sensor: the cone clears the wall over both published detection thresholds, 370 and 600 mm",
            h.cone_height(600.0) > h.wall_height,
            f"lower edge at {h.cone_height(370):.1f} and {h.cone_height(600):.1f} mm; sinks to the wall at {h.wall_clear_distance:.0f} mm",
        ),
        Check(
            "sensor: another robot's hat stands in the cone at both thresholds",
            all(h.hat_top - h.cone_height(d) > 20.0 for d in (370.0, 600.0)),
            f"{h.hat_top - h.cone_height(370):.1f} and {h.hat_top - h.cone_height(600):.1f} mm of the hat above the lower edge",
        ),
        *segments,
    ]


def sensor_cone(h: Hardware, half_angle: float, length: float) -> Any:
    """Return the sensor's field of view as a solid, from the middle of its face."""
    from build123d import Align, Cone, Pos, Rot

    from hardware.cad.hat import sensor_place

    far = length * math.tan(math.radians(half_angle))
    return sensor_place(h) * Pos(0.05, 0, 0) * Rot(0, 90, 0) * Cone(0.2, far, length, align=(Align.CENTER, Align.CENTER, Align.MIN))


def stance_checks(h: Hardware, items: Sequence[Item]) -> list[Check]:
    """Does it stand, and where does its weight lie?"""
    lowest = {item.name: item.solid.bounding_box().min.Z for item in items}
    mass, centre = balance(items)
    clearance = min(z for name, z in lowest.items() if not name.startswith(("O-ring", "rear skid", "front skid", "wheel", "encoder")))
    track = h.wheel_base / 2
    margin = min(abs(centre[0]), h.skid_x - abs(centre[0]), track - abs(centre[1]))
    return [
        _same("stance: the rear skid touches the floor", lowest["rear skid"], 0.0),
        _same("stance: the front skid hangs above it", lowest["front skid"], h.front_skid_lift),
        Check("stance: nothing reaches below the floor", min(lowest.values()) > -0.01, f"lowest {min(lowest.values()):.3f} mm"),
        Check("stance: everything but wheels and skids keeps 2.5 mm from the floor", clearance >= 2.5, f"{clearance:.2f} mm"),
        Check(
            "stance: the encoder discs keep 1.5 mm from the floor",
            h.axle_height - h.disc_radius >= 1.5,
            f"{h.axle_height - h.disc_radius:.2f} mm",
        ),
        Check(
            "stance: the centre of mass lies behind the axle, over the triangle of wheels and rear skid",
            centre[0] < 0 and margin >= 1.0,
            f"{mass:.0f} g at x = {centre[0]:.1f}, y = {centre[1]:.1f}, z = {centre[2]:.1f} mm",
        ),
    ]


def balance(items: Sequence[Item]) -> tuple[float, tuple[float, float, float]]:
    """Return the robot's mass in g and its centre in mm; bought parts are taken as evenly dense."""
    masses = [mass_of(item) for item in items]
    total = sum(masses)
    centres = [item.solid.center() for item in items]
    x, y, z = (sum(m * getattr(c, axis) for m, c in zip(masses, centres, strict=True)) / total for axis in ("X", "Y", "Z"))
    return total, (x, y, z)


def mass_of(item: Item) -> float:
    """Mass of a piece in g: bought parts from ``MASSES``, the rest from its volume."""
    for name, mass in MASSES.items():
        if (item.name == name or item.name.rsplit(" ", 1)[0] == name) and (item.kind in (BOUGHT, BOARD, CELL) or name == "standoff"):
            return mass
    return float(item.solid.volume) * DENSITY[item.kind]


def interference(items: Sequence[Item]) -> list[Pair]:
    """Intersect every two pieces whose bounding boxes overlap; pairs without a common box share nothing."""
    return [
        Pair(a.name, b.name, shared_volume(a.solid, b.solid), b.name in a.screwed or a.name in b.screwed) for a, b in close_pairs(items)
    ]


def close_pairs(items: Sequence[Item], margin: float = 0.0) -> Iterator[tuple[Item, Item]]:
    """Pairs whose bounding boxes come within ``margin`` mm of each other."""
    boxes = {item.name: item.solid.bounding_box() for item in items}
    for a, b in itertools.combinations(items, 2):
        if gap(boxes[a.name], boxes[b.name]) < margin:
            yield a, b


def gap(p: Any, q: Any) -> float:
    """Distance between two bounding boxes along their most separate axis; negative where they overlap."""
    return float(max(max(getattr(p.min, x) - getattr(q.max, x), getattr(q.min, x) - getattr(p.max, x)) for x in "XYZ"))


def most_in_the_way(body: Any, items: Sequence[Item]) -> tuple[str, float]:
    """Return the item that shares the largest volume with a body, and that volume in mm³."""
    box = body.bounding_box()
    shared = {item.name: shared_volume(body, item.solid) for item in items if gap(box, item.solid.bounding_box()) < 0}
    return max(shared.items(), key=lambda entry: entry[1], default=("nothing", 0.0))


def shared_volume(a: Any, b: Any) -> float:
    """Volume of the boolean intersection, mm³."""
    common = a & b
    if common is None:
        return 0.0
    return float(sum(solid.volume for solid in common.solids()))


def plug_checks(h: Hardware, items: Sequence[Item]) -> list[Check]:
    """Do the charging plug and the NodeMCU's USB plug reach their sockets with the robot closed?"""
    from hardware.cad.power_tray import CHARGER_REAR
    from hardware.cad.shapes import block

    z = h.pillar_top + h.tray_thickness + 2.9
    charging = block((-70.0, CHARGER_REAR - 1.0), (-6.5, 6.5), (z - 3.5, z + 3.5))
    z = h.deck_top + 5.0 + h.boards.carrier[2] + h.boards.socket_height + h.boards.nodemcu[2] + 1.4
    usb = block((h.nodemcu_x - 5.5, h.nodemcu_x + 5.5), (h.boards.nodemcu[0] / 2 + 0.8, 70.0), (z - 4.0, z + 4.0))
    found = []
    for name, plug in (("charging plug, 13 x 7 mm", charging), ("USB plug of the NodeMCU, 11 x 8 mm", usb)):
        worst, volume = most_in_the_way(plug, items)
        found.append(Check(f"access: {name}, reaches its socket", volume <= TOUCH, f"most in its way: {worst}, {volume:.3f} mm³"))
    return found


def clearance_checks(h: Hardware, items: Sequence[Item]) -> list[Check]:
    """Least distance between what turns with a wheel and what does not; a servo, its shaft and its horn belong together."""
    worst: tuple[float, str, str] = (math.inf, "", "")
    for a, b in close_pairs(items, margin=h.print.moving + 0.1):
        if a.turns == b.turns or {a.name.split()[0], b.name.split()[0]} in ({"horn", "servo"}, {"output", "servo"}):
            continue
        worst = min(worst, (float(a.solid.distance_to(b.solid)), a.name, b.name))
    passed = worst[0] >= h.print.moving - 1e-6
    return [Check("clearance: whatever turns keeps its distance from whatever does not", passed, _nearest(worst, h.print.moving))]


def _nearest(worst: tuple[float, str, str], wanted: float) -> str:
    if math.isinf(worst[0]):
        return f"nothing nearer than {wanted:g} mm"
    return f"nearest: {worst[1]} and {worst[2]}, {worst[0]:.2f} mm; wanted {wanted:g} mm"


def arena_checks(h: Hardware, world: WorldSpec, wall: Any) -> list[Check]:
    """Do the printed walls close the world's arena, and does the template have its grid?"""
    length, leg, long, short = h.wall_plan
    sides = (long * length + 2 * leg, short * length + 2 * leg)
    links = h.template_links
    box = wall.bounding_box()
    return [
        _same("arena: wall height is the robot file's", box.size.Z, h.wall_height),
        _same("arena: long side closes", sides[0], max(h.arena)),
        _same("arena: short side closes", sides[1], min(h.arena)),
        _same("start grid: node, bar, node give the world's spacing along x", links[0] + 2 * h.template_arm, 1000 * world.start.spacing_x),
        _same("start grid: and along y", links[1] + 2 * h.template_arm, 1000 * world.start.spacing_y),
    ]

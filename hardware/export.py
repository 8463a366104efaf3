"""``python -m hardware.export``: build every part, check the design, write STEP, STL and pictures.

Writes below ``build/hardware`` (or ``--out``): ``step/``, ``stl/``, ``png/``, ``checks.md``, ``interference.csv``, ``print_list.csv``.
Ends with status 1 if a check fails. ``--docs`` also renews the pictures in ``hardware/docs/images``.
"""

from __future__ import annotations

import argparse
import csv
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hardware.dimensions import Hardware, hardware
from swarm_envs.worlds import load_world

if TYPE_CHECKING:
    from hardware.cad.assembly import Item
    from hardware.cad.catalogue import Printed
    from hardware.checks import Check, Pair

IMAGES = Path(__file__).parent / "docs" / "images"
STEPS = {
    1: (0.6, -1.3, 0.9),
    2: (-1.0, -1.0, 1.0),
    3: (1.0, -1.2, 0.8),
    4: (-1.0, -1.2, 1.0),
    5: (0.8, -1.5, 0.35),
    6: (0.9, -1.4, 0.8),
    7: (1.0, -1.0, 1.0),
    8: (1.0, -1.1, -0.7),
    9: (1.0, -1.2, 0.9),
    10: (1.2, -1.0, 0.8),
}
"""Where the viewer stands in each step's picture."""


def main(arguments: list[str] | None = None) -> int:
    """Run the export; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m hardware.export", description="Export and check the HeRo+ hardware.")
    parser.add_argument("--out", type=Path, default=Path("build/hardware"), help="folder to write (default: %(default)s)")
    parser.add_argument("--robot", default="hero_plus", help="robot file, by name or path")
    parser.add_argument("--world", default="hero_plus", help="world whose arena and start grid are built, by name or path")
    parser.add_argument("--no-pictures", action="store_true", help="write no PNG")
    parser.add_argument("--docs", action="store_true", help="also renew the pictures in hardware/docs/images")
    options = parser.parse_args(arguments)
    try:
        import build123d  # noqa: F401
        import trimesh  # noqa: F401
        import vtk  # noqa: F401
    except ImportError as error:
        print(f"{error.name} is missing; install the extra: pip install -e '.[hardware]'", file=sys.stderr)
        return 2
    h = hardware(options.robot, options.world)
    checks, pairs = export(h, options.world, options.out)
    failed = _report(checks, pairs, options.out)
    if not options.no_pictures:
        pictures(h, options.out / "png")
    if options.docs:
        pictures(h, IMAGES)
    return 1 if failed else 0


def export(h: Hardware, world: str, out: Path) -> tuple[list[Check], list[Pair]]:
    """Write STEP and STL of every part and the assembly; return what was checked."""
    from build123d import export_step, export_stl

    from hardware import checks
    from hardware.cad.arena import wall_segment
    from hardware.cad.assembly import compound, robot
    from hardware.cad.catalogue import printed_parts

    spec = load_world(world)
    for folder in ("step", "stl"):
        (out / folder).mkdir(parents=True, exist_ok=True)
    found: list[Check] = []
    rows = []
    for part in printed_parts(h):
        solid = part.on_bed(h)
        stl = out / "stl" / f"{part.name}.stl"
        export_step(solid, out / "step" / f"{part.name}.step")
        export_stl(solid, stl, tolerance=0.02, angular_tolerance=0.1)
        found += checks.part_checks(part, solid, stl)
        rows.append(_print_row(part, solid))
    items = robot(h)
    export_step(compound(items), out / "step" / "hero_plus.step")
    found += checks.agreement_checks(h, spec, items)
    found += checks.sensor_checks(h, items)
    found += checks.stance_checks(h, items)
    found += checks.plug_checks(h, items)
    found += checks.clearance_checks(h, items)
    found += checks.arena_checks(h, spec, wall_segment(h))
    pairs = checks.interference(items) + checks.interference(joints(h))
    bad = [pair for pair in pairs if not pair.passed]
    threads = sum(pair.thread for pair in pairs)
    detail = f"{len(pairs)} pairs with overlapping boxes, {threads} of them threads, {len(bad)} interfere"
    found.append(checks.Check("assembly: no two pieces share volume but a screw and its thread", not bad, detail))
    _write_rows(out / "print_list.csv", rows)
    return found, pairs


def joints(h: Hardware) -> list[Item]:
    """Return the arena's and the template's joints as they lie assembled: segment, corner, segment; node, bar."""
    from build123d import Pos, Rot

    from hardware.cad.arena import wall_corner, wall_segment
    from hardware.cad.assembly import PRINTED, Item
    from hardware.cad.start_grid import template_link_x, template_link_y, template_node

    length, leg, _, _ = h.wall_plan
    segment, arm = wall_segment(h), h.template_arm
    away = Pos(0, 0, 1000)
    solids = {
        "wall segment before": Pos(-leg - length, 0, 0) * segment,
        "wall segment before that": Pos(-leg - 2 * length, 0, 0) * segment,
        "wall corner": wall_corner(h),
        "wall segment after": Rot(0, 0, 90) * Pos(leg, 0, 0) * segment,
        "template node": away * template_node(h),
        "template bar along x": away * Pos(arm, 0, 0) * template_link_x(h),
        "template bar along y": away * Rot(0, 0, 90) * Pos(arm, 0, 0) * template_link_y(h),
    }
    return [Item(name, solid, PRINTED, 0, (0, 0, 0)) for name, solid in solids.items()]


def _print_row(part: Printed, solid: Any) -> dict[str, Any]:
    from hardware.cad.assembly import PRINTED
    from hardware.checks import DENSITY

    box = solid.bounding_box()
    return {
        "part": part.name,
        "per_robot": part.per_robot,
        "per_arena": part.per_arena,
        "x_mm": round(box.size.X, 1),
        "y_mm": round(box.size.Y, 1),
        "z_mm": round(box.size.Z, 1),
        "solid_g": round(solid.volume * DENSITY[PRINTED], 1),
    }


def _write_rows(path: Path, rows: list[dict[str, Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, fieldnames=list(rows[0]))
        writer.writeheader()
        writer.writerows(rows)


def _report(checks: list[Check], pairs: list[Pair], out: Path) -> int:
    """Write the checks, print them, and return how many failed."""
    _write_rows(
        out / "interference.csv",
        [{"first": p.first, "second": p.second, "shared_mm3": round(p.volume, 4), "thread": p.thread, "passed": p.passed} for p in pairs],
    )
    lines = ["# Checks of the HeRo+ hardware", "", "| | claim | numbers |", "|---|---|---|"]
    for check in checks:
        lines.append(f"| {'ok' if check.passed else 'FAILED'} | {check.claim} | {check.detail} |")
        print(f"{'ok    ' if check.passed else 'FAILED'} {check.claim} ({check.detail})")
    for pair in pairs:
        if not pair.passed:
            print(f"FAILED {pair.first} and {pair.second} share {pair.volume:.2f} mm³")
    (out / "checks.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    failed = sum(not check.passed for check in checks)
    print(f"{len(checks)} checks, {failed} failed; written to {out}")
    return failed


def pictures(h: Hardware, out: Path) -> None:
    """Draw every part, the robot, the exploded view and the steps of the assembly."""
    from hardware.cad.assembly import COLOURS, PRINTED, robot
    from hardware.cad.catalogue import printed_parts
    from hardware.render import Body, draw

    for part in printed_parts(h):
        draw([Body(part.on_bed(h), COLOURS[PRINTED])], out / f"{part.name}.png", size=(480, 360))
    items = robot(h)
    draw([Body(i.solid, i.colour) for i in items], out / "hero_plus.png")
    shell = {"bump shield", "hat"}
    draw([Body(i.solid, i.colour, opacity=0.22 if i.name in shell else 1.0) for i in items], out / "inside.png", colours=128)
    _exploded(items, out / "exploded.png")
    _wheel_unit(items, out / "wheel_unit.png")
    _arena(h, out)
    for step, direction in STEPS.items():
        _step(items, step, direction, out / f"step_{step:02d}.png")


def _wheel_unit(items: list[Item], path: Path) -> None:
    """The right wheel's pieces apart along the axle, seen from outside and from the servo's side in one row."""
    from hardware.render import Body, Label, draw

    bodies: list[Body] = []
    labels: list[Label] = []
    shifts = {"horn": 34.0, "wheel": 0.0, "O-ring": -26.0, "encoder disc": -52.0, "encoder disc screw": -72.0}
    for item in items:
        if item.step != 5 or " right" not in item.name:
            continue
        name = item.name.rstrip(" 0123456789").replace(" right", "")
        shift = (0.0, shifts[name], 0.0)
        bodies.append(Body(item.solid, item.colour, shift))
        box = item.solid.bounding_box()
        if any(label.text == name for label in labels):
            continue
        labels.append(Label(name, ((box.min.X + box.max.X) / 2, item.solid.center().Y + shift[1], box.max.Z)))
    draw(bodies, path, size=(760, 420), direction=(-1.0, 0.55, 0.35), labels=labels, margin=1.4)


def _arena(h: Hardware, out: Path) -> None:
    """A corner between two segments, and one cell of the start-grid template with a robot's shield on a node."""
    from build123d import Pos, Rot

    from hardware.cad.arena import wall_corner, wall_segment
    from hardware.cad.assembly import COLOURS, PRINTED, SHIELD_COLOUR
    from hardware.cad.bump_shield import bump_shield
    from hardware.cad.start_grid import template_link_x, template_link_y, template_node
    from hardware.render import Body, draw

    length, leg, _, _ = h.wall_plan
    segment, yellow = wall_segment(h), COLOURS[PRINTED]
    pieces = [Pos(-leg - length, 0, 0) * segment, Rot(0, 0, 90) * Pos(leg, 0, 0) * segment]
    bodies = [Body(wall_corner(h), SHIELD_COLOUR), *(Body(piece, yellow) for piece in pieces)]
    draw(bodies, out / "arena_corner.png", size=(760, 420), direction=(0.55, -1.2, 0.9))
    (dx, dy), node, arm = h.spacing, template_node(h), h.template_arm
    bodies = [Body(Pos(x, y, 0) * node, yellow) for x in (0.0, dx) for y in (0.0, dy)]
    bodies += [Body(Pos(arm, y, 0) * template_link_x(h), (0.0, 0.45, 0.55)) for y in (0.0, dy)]
    bodies += [Body(Pos(x, arm, 0) * Rot(0, 0, 90) * template_link_y(h), (0.0, 0.45, 0.55)) for x in (0.0, dx)]
    bodies.append(Body(bump_shield(h), SHIELD_COLOUR))
    draw(bodies, out / "start_grid.png", size=(760, 520), direction=(0.5, -1.0, 1.1))


EXPLODED_LABELS = (
    "hat", "ToF sensor", "NodeMCU", "carrier board", "encoder bracket left", "power switch", "deck", "optical switch right",
    "standoff 1", "boost converter", "power tray", "encoder disc right", "O-ring right", "wheel right", "horn left", "servo right",
    "body plate", "cell", "battery tray", "front skid", "rear skid", "ballast 1", "bump shield",
)  # fmt: skip


def _exploded(items: list[Item], path: Path) -> None:
    from hardware.render import Body, Label, draw

    labels = []
    for item in items:
        if item.name in EXPLODED_LABELS:
            centre = item.solid.center()
            text = item.name.removesuffix(" left").removesuffix(" right").removesuffix(" 1")
            point = (centre.X + item.explode[0], centre.Y + item.explode[1], centre.Z + item.explode[2])
            labels.append(Label(text, point))
    bodies = [Body(item.solid, item.colour, item.explode) for item in items]
    draw(bodies, path, size=(900, 1150), direction=(1.0, -1.4, 0.5), labels=labels, margin=1.02, colours=96)


def _step(items: list[Item], step: int, direction: tuple[float, float, float], path: Path) -> None:
    """What is there already in grey, what the step adds in colour and labelled."""
    from hardware.render import Body, Label, draw

    bodies = [Body(item.solid, (0.80, 0.80, 0.80)) for item in items if item.step < step]
    labels: dict[str, Label] = {}
    for item in items:
        if item.step != step:
            continue
        bodies.append(Body(item.solid, item.colour, opacity=0.45 if item.name in ("bump shield", "hat") else 1.0))
        name = item.name.rstrip(" 0123456789").replace(" left", "").replace(" right", "")
        centre = item.solid.center()
        if name not in labels or labels[name].point[1] > centre.Y:
            labels[name] = Label(name, (centre.X, centre.Y, centre.Z))
    draw(bodies, path, size=(760, 520), direction=direction, labels=list(labels.values()), margin=1.05)


if __name__ == "__main__":
    sys.exit(main())

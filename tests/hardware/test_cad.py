"""The solids: valid, watertight, printable, agreeing with the files, not interfering."""

from __future__ import annotations

import csv
import subprocess
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from PIL import Image

pytest.importorskip("build123d", reason="CAD tests need the extra: pip install -e '.[hardware]'")
pytest.importorskip("trimesh", reason="CAD tests need the extra: pip install -e '.[hardware]'")

from hardware import checks
from hardware.bom import load_bom
from hardware.cad.assembly import PRINTED, Item, robot
from hardware.cad.bump_shield import bump_shield
from hardware.cad.wheel import wheel
from hardware.dimensions import Hardware, hardware
from hardware.export import export
from swarm_envs.worlds import load_world

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def h() -> Hardware:
    return hardware()


@pytest.fixture(scope="module")
def items(h: Hardware) -> list[Item]:
    return robot(h)


@pytest.fixture(scope="module")
def exported(h: Hardware, tmp_path_factory: pytest.TempPathFactory) -> tuple[list[checks.Check], list[checks.Pair], Path]:
    out = tmp_path_factory.mktemp("hardware")
    return *export(h, "hero_plus", out), out


def test_every_check_passes(exported: tuple[list[checks.Check], list[checks.Pair], Path]) -> None:
    assert [check for check in exported[0] if not check.passed] == []


def test_no_two_pieces_interfere(exported: tuple[list[checks.Check], list[checks.Pair], Path]) -> None:
    pairs = exported[1]
    assert len(pairs) > 200
    assert [pair for pair in pairs if not pair.passed] == []


def test_step_and_stl_of_every_part_are_written(exported: tuple[list[checks.Check], list[checks.Pair], Path]) -> None:
    out = exported[2]
    with (out / "print_list.csv").open(newline="") as file:
        parts = [row["part"] for row in csv.DictReader(file)]
    assert {path.stem for path in (out / "stl").iterdir()} == set(parts)
    assert {path.stem for path in (out / "step").iterdir()} == {*parts, "hero_plus"}
    assert (out / "step" / "hero_plus.step").read_text(encoding="utf-8", errors="replace").startswith("ISO-10303-21")


def _by_name(items: list[Item], name: str) -> Item:
    return next(item for item in items if item.name == name)


def test_the_interference_check_sees_a_wheel_that_is_too_wide(h: Hardware, items: list[Item]) -> None:
    switch, wide = _by_name(items, "optical switch left"), replace(h, wheel_width=h.wheel_width + 3.0)
    fat = replace(_by_name(items, "wheel left"), solid=wheel(wide))
    assert any(not pair.passed for pair in checks.interference([fat, switch]))


def test_the_agreement_check_sees_a_larger_shield(h: Hardware, items: list[Item]) -> None:
    larger = replace(h, shield_radius=61.0)
    swapped = [replace(item, solid=bump_shield(larger)) if item.name == "bump shield" else item for item in items]
    failed = {check.claim for check in checks.agreement_checks(larger, load_world("hero_plus"), swapped) if not check.passed}
    assert any(claim.startswith("shield: lies inside") for claim in failed)


def test_a_picture_is_drawn_without_a_display(tmp_path: Path) -> None:
    pytest.importorskip("vtk", reason="pictures need the extra: pip install -e '.[hardware]'")
    program = (
        "from build123d import Box; from pathlib import Path; from hardware.render import Body, draw; "
        f"draw([Body(Box(10, 10, 10), (1, 0, 0))], Path({str(tmp_path / 'box.png')!r}), size=(80, 60))"
    )
    run = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, timeout=600)
    if run.returncode < 0 or "no working EGL or OSMesa" in run.stderr:
        pytest.skip("this machine has no off-screen OpenGL (Debian: libegl1 libgl1-mesa-dri)")
    assert run.returncode == 0, run.stderr
    with Image.open(tmp_path / "box.png") as picture:
        assert picture.size == (80, 60)
        assert len(picture.convert("RGB").getcolors() or []) > 3


def test_the_stance_check_sees_a_robot_without_ballast(h: Hardware, items: list[Item]) -> None:
    light = [item for item in items if not item.name.startswith("ballast")]
    failed = [check.claim for check in checks.stance_checks(h, light) if not check.passed]
    assert any("centre of mass" in claim for claim in failed)


def test_the_bill_of_materials_counts_what_the_assembly_holds(items: list[Item]) -> None:
    held = Counter(_bom_part(item.name) for item in items if item.kind != PRINTED)
    del held[""]
    held["screw_m2x6"] += 4  # through the horns' arms into the wheels, not drawn
    billed = {line.part: line.quantity for line in load_bom()}
    assert {part: billed[part] for part in held} == dict(held)


def test_the_bill_of_materials_has_filament_for_every_printed_part(items: list[Item]) -> None:
    needed = sum(checks.mass_of(item) for item in items if item.kind == PRINTED)
    billed = next(line.quantity for line in load_bom() if line.part == "filament")
    assert needed <= billed <= 1.3 * needed


SAME = {
    "servo": "servo", "O-ring": "o_ring", "cell": "cell", "charger": "charger", "boost converter": "boost_converter",
    "standoff": "standoff", "power switch": "power_switch", "optical switch": "optical_switch", "carrier board": "carrier_board",
    "NodeMCU": "controller", "ToF sensor": "tof_sensor", "ballast": "nut_m8", "ToF nut": "nut_m25", "ToF screw": "screw_m25x8",
    "deck screw": "screw_m3x6", "standoff screw": "screw_m3x8", "bracket screw": "screw_m3x8", "switch screw": "screw_m3x8",
    "hat screw": "screw_m3x8", "shield screw": "screw_m3x10", "front skid screw": "screw_m3x20", "rear skid screw": "screw_m3x20",
    "power tray screw": "screw_m2x6", "carrier screw": "screw_m2x6", "encoder disc screw": "screw_m2x6",
    "horn": "", "output shaft": "", "servo screw": "",  # come with the servo
}  # fmt: skip


def _bom_part(name: str) -> str:
    plain = name.rstrip(" 0123456789").replace(" left", "").replace(" right", "")
    return "nut_m3" if plain.endswith("nut") and not plain.startswith("ToF") else SAME[plain]

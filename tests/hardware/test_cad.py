"""The solids: valid, watertight, printable, agreeing with the files, not interfering."""

from __future__ import annotations

import csv
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("build123d", reason="CAD tests need the extra: pip install -e '.[hardware]'")
pytest.importorskip("trimesh", reason="CAD tests need the extra: pip install -e '.[hardware]'")

from hardware import checks
from hardware.bom import load_bom
from hardware.cad.assembly import PRINTED, Item, robot
from hardware.dimensions import Hardware, hardware
from hardware.export import export
from swarm_envs.worlds import load_world


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


def _by_name(items: list[Item], name: str) -> Any:
    return next(item for item in items if item.name == name)


def test_the_interference_check_sees_a_wheel_that_is_too_wide(h: Hardware) -> None:
    wide = replace(h, wheel_width=h.wheel_width + 3.0)
    moved = [_by_name(robot(h), "body plate"), _by_name(robot(wide), "wheel left")]
    switch = _by_name(robot(h), "optical switch left")
    assert any(not pair.passed for pair in checks.interference([*moved, switch]))


def test_the_agreement_check_sees_a_larger_shield(h: Hardware) -> None:
    larger = replace(h, shield_radius=61.0)
    failed = {check.claim for check in checks.agreement_checks(larger, load_world("hero_plus"), robot(larger)) if not check.passed}
    assert any(claim.startswith("shield: lies inside") for claim in failed)


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

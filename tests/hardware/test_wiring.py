"""The wiring table: every pin of the robot file, as the firmware has it, and every part connected."""

import re
from pathlib import Path

import pytest

from hardware.wiring import BOARD_LABELS, Wire, as_table, load_wiring
from swarm_envs.worlds import load_robot_file

ROOT = Path(__file__).parents[2]
CONFIG = ROOT / "firmware" / "core" / "hero_config.h"


@pytest.fixture(scope="module")
def wires() -> list[Wire]:
    return load_wiring()


@pytest.fixture(scope="module")
def wired(wires: list[Wire]) -> dict[str, int | None]:
    return {wire.signal: wire.gpio for wire in wires if wire.signal}


def test_every_pin_of_the_robot_file_is_wired_to_its_gpio(wired: dict[str, int | None]) -> None:
    assert wired == load_robot_file("hero_plus")["electronics"]["pins"]


def test_every_pin_of_the_firmware_is_wired_to_its_gpio(wired: dict[str, int | None]) -> None:
    if not CONFIG.is_file():
        pytest.skip("this checkout has no firmware/core/hero_config.h to compare with")
    pins = re.findall(r"^#define HERO_PIN_(\w+)\s+(\d+)", CONFIG.read_text(encoding="utf-8"), re.MULTILINE)
    assert {name.lower(): int(gpio) for name, gpio in pins} == wired


def test_the_labels_are_the_boards(wires: list[Wire]) -> None:
    for wire in wires:
        if wire.gpio is not None:
            assert wire.board_label == BOARD_LABELS[wire.gpio], wire


def test_no_two_signals_share_a_gpio(wired: dict[str, int | None]) -> None:
    assert len(set(wired.values())) == len(wired)


def test_every_consumer_has_supply_and_ground(wires: list[Wire]) -> None:
    def nets(end: str) -> set[str]:
        return {wire.net for wire in wires if wire.end == end}

    for servo in ("servo left", "servo right"):
        assert {"5V", "GND"} < nets(servo)
    for part in ("tof_sensor", "schmitt_trigger"):
        assert {"3V3", "GND"} < nets(part)
    for switch in ("optical_switch left", "optical_switch right"):
        assert "GND" in nets(switch)


def test_the_battery_divider_gives_the_full_scale_that_the_firmware_assumes() -> None:
    scale = load_robot_file("hero_plus")["electronics"]["battery_full_scale"]
    assert scale == pytest.approx((180 + 220 + 100) / 100)
    assert any(wire.net == "BATTERY_SENSE" and wire.end_pin == "180 kOhm" for wire in load_wiring())


def test_the_docs_carry_the_table_of_the_file(wires: list[Wire]) -> None:
    assert as_table(wires) in (ROOT / "hardware" / "docs" / "wiring.md").read_text(encoding="utf-8")

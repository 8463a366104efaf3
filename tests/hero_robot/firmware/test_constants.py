"""World, CAD and firmware read one file of numbers; these tests fail when they part."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import pytest
import yaml

from hero_robot.firmware import FirmwareError, FirmwareSwarm
from hero_robot.firmware.constants import render_header, robot_constants
from hero_robot.firmware.sources import core_folder
from swarm_envs.worlds import load_robot_file, load_world
from swarm_envs.worlds.load import ROBOTS


def constants(robot_file: str | Path = "hero_plus") -> dict[str, int]:
    return {constant.name: constant.value for constant in robot_constants(robot_file)}


def test_the_header_in_the_tree_is_that_of_the_robot_file() -> None:
    written = (core_folder() / "hero_config.h").read_text(encoding="utf-8")
    assert written == render_header("hero_plus"), "run python -m hero_robot.firmware.constants and commit the header"


def test_the_simulated_world_and_the_firmware_agree() -> None:
    robot = load_world("hero_plus").robots[0]
    header = constants()
    assert header["WHEEL_BASE"] == round(robot.drive.wheel_base * 65536)
    assert header["MAX_SPEED"] == round(robot.drive.max_linear_speed * 65536)
    assert header["MAX_TURN"] == round(robot.drive.max_angular_speed * 65536)
    assert header["TOF_THRESHOLD_MM"] == round(robot.sensors[0].range * 1000)


def test_derived_constants_follow_from_the_dimensions() -> None:
    parts, header = load_robot_file("hero_plus")["parts"], constants()
    tick = math.pi * parts["wheel_diameter"] / parts["encoder_ticks"]
    assert header["TICK_SPEED"] / 65536e6 == pytest.approx(tick, rel=1e-8)
    assert header["HALF_TICK"] / 2**24 == pytest.approx(tick / 2, rel=4e-5)
    assert 2 * header["HALF_TICK_TURN"] / 2**32 * 2 * math.pi == pytest.approx(tick / 0.063, rel=1e-6)
    if "encoder_slots" in parts:
        assert 2 * parts["encoder_slots"] == parts["encoder_ticks"]


def test_the_safety_numbers_are_those_promised() -> None:
    assert constants()["LEASE_MAX_US"] == 500_000
    assert constants()["CONTROL_PERIOD_US"] == 20_000


def changed_robot(folder: Path, section: str, name: str, value: float) -> Path:
    document = yaml.safe_load((ROBOTS / "hero_plus.yaml").read_text(encoding="utf-8"))
    document[section][name]["value"] = value
    path = folder / "changed.yaml"
    path.write_text(yaml.safe_dump(document), encoding="utf-8")
    return path


def test_every_number_of_the_header_moves_with_its_source(tmp_path: Path) -> None:
    before = render_header()
    for section, name, value in [
        ("drive", "wheel_base", 0.0646),
        ("parts", "wheel_diameter", 0.048),
        ("parts", "encoder_ticks", 288),
        ("electronics", "velocity_kp", 900),
        ("electronics", "servo_span_us", 300),
        ("electronics", "tof_debounce", 3),
        ("electronics", "battery_cutoff", 3.2),
    ]:
        assert render_header(changed_robot(tmp_path, section, name, value)) != before, name


def test_another_robot_file_is_another_firmware(tmp_path: Path) -> None:
    slow = changed_robot(tmp_path, "drive", "max_linear_speed", 0.05)
    with pytest.raises(FirmwareError, match=r"beyond \+-\[0.05"):
        FirmwareSwarm(slow, 1, (0.08, 0, 0, 0))
    swarm = FirmwareSwarm(slow, 1, (0.04, 0, 0, 0))
    swarm.boards[0].boot()
    swarm.boards[0].run(0.1)
    assert not swarm.boards[0].start((0.08, 0.0, 0.0, 0.0)), "the compiled-in limit must refuse what the file forbids"


def test_a_missing_number_is_named(tmp_path: Path) -> None:
    document = yaml.safe_load((ROBOTS / "hero_plus.yaml").read_text(encoding="utf-8"))
    del document["electronics"]["velocity_kp"]
    path = tmp_path / "poor.yaml"
    path.write_text(yaml.safe_dump(document), encoding="utf-8")
    with pytest.raises(FirmwareError, match="'velocity_kp' is missing"):
        render_header(path)


def test_without_a_compiler_one_line_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from hero_robot.firmware import library

    monkeypatch.setenv("HERO_FIRMWARE_CACHE", str(tmp_path / "empty"))
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CC", raising=False)
    assert shutil.which("cc") is None
    with pytest.raises(FirmwareError) as caught:
        library.build()
    assert "no C compiler" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_was_built_is_taken_from_the_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from hero_robot.firmware import library

    monkeypatch.setenv("HERO_FIRMWARE_CACHE", str(tmp_path))
    first = library.build()
    stamp = first.stat().st_mtime_ns
    monkeypatch.setenv("PATH", "")
    assert library.build() == first
    assert first.stat().st_mtime_ns == stamp

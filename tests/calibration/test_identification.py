"""An effect hidden in a log is named; nothing is named where nothing is hidden."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from docs.studies.calibration.generator import generate_log
from swarm_envs import load_world
from swarm_envs.calibration import calibrate, read_log
from swarm_envs.calibration.drive.identification import identify
from swarm_envs.calibration.report.page import write_folder

HIDDEN = {
    "nothing": {},
    "dead_time": {"dead_time": {"delay": 0.15}},
    "motor_lag": {"motor_lag": {"time_constant": 0.34}},
    "robot_spread and linear_gain": {"robot_spread": {"sd": 0.1}, "linear_gain": {"gain": 0.75}},
}


@pytest.mark.parametrize("effects", HIDDEN.values(), ids=HIDDEN)
def test_exactly_what_is_hidden_is_named(effects: dict[str, dict[str, float]], tmp_path: Path) -> None:
    log = read_log(generate_log(effects, tmp_path / "log", seed=2, runs=5, position_noise=5e-4, heading_noise=2e-3, procedures=["drives"]))
    found = identify(log, load_world("hero_plus"))
    assert {cause.effect for cause in found.causes} == set(effects)
    for cause in found.causes:
        for name, truth in effects[cause.effect].items():
            low, high = cause.parameters[name].ci95
            assert low - 1e-3 <= truth <= high + 1e-3


def test_effects_of_the_sensor_are_named_and_the_extended_world_holds_them(tmp_path: Path) -> None:
    effects = {"sensor_yaw": {"yaw": 0.15}}
    log = generate_log(effects, tmp_path / "log", seed=2, runs=5, position_noise=5e-4, heading_noise=2e-3, procedures=["swarm"])
    findings = calibrate(log, "hero_plus")
    assert [cause.effect for cause in findings.causes] == ["sensor_yaw"]
    write_folder(findings, tmp_path / "out")
    world = load_world(tmp_path / "out" / "extended.yaml")
    assert world.robots[0].effects.sensor_yaw == pytest.approx(0.15, abs=0.01)
    assert "95 % interval" in world.provenance["robot.effects.sensor_yaw"].source
    content = json.loads((tmp_path / "out" / "findings.json").read_text())
    assert content["causes"][0]["parameters"]["yaw"]["unit"] == "rad"
    assert (tmp_path / "out" / "report.html").stat().st_size > 10_000

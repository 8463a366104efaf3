"""Real robots' logs: the calibrated world predicts runs that it was not fitted to better than the ideal one.

The logs lie beside the repository and are no part of it. HeRo's are calibrated in every run of the tests; all of them, and with every run
left out in turn, with the environment variable CALIBRATION_STUDY set.
"""

from __future__ import annotations

import dataclasses
import os
import time
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from swarm_envs import load_world
from swarm_envs.calibration import Findings, calibrate, evaluate, read_log
from swarm_envs.calibration.validation.leave_one_out import leave_one_out

MEASURED = Path(__file__).parents[3] / "shared" / "measured"
STUDY = bool(os.environ.get("CALIBRATION_STUDY"))
IDEAL = load_world("hero").with_effects(linear_gain=1.0, dead_time=0.0)
LOGS = [
    "hero_2018",
    *(
        pytest.param(name, marks=pytest.mark.skipif(not STUDY, reason="CALIBRATION_STUDY is not set"))
        for name in ("epuck_2018", "create_2009")
    ),
]

pytestmark = pytest.mark.skipif(not MEASURED.is_dir(), reason=f"no measured logs at {MEASURED}")


@cache
def calibrated(name: str) -> tuple[Findings, float]:
    """Findings about a log, and the processor time in s that they took."""
    begin = time.process_time()
    return calibrate(MEASURED / name, IDEAL), time.process_time() - begin


@pytest.mark.slow
@pytest.mark.parametrize("name", LOGS)
def test_the_calibrated_world_predicts_held_out_runs_better_at_every_horizon(name: str) -> None:
    findings, seconds = calibrated(name)
    gains = {(gain.metric, gain.horizon_s): gain for gain in findings.gain}
    assert set(gains) == {(metric, horizon) for metric in ("position", "heading") for horizon in (1.0, 5.0, 10.0)}
    for key, gain in gains.items():
        assert gain.after < gain.before, key
        assert gain.ci95[0] > 0, key
    if STUDY:  # beside other tests on a busy machine a time says little
        assert seconds < 120


@pytest.mark.slow
def test_the_turn_commands_of_hero_are_found_to_be_in_units_of_its_driver() -> None:
    findings, _ = calibrated("hero_2018")
    causes = {cause.effect: cause.parameters for cause in findings.causes}
    assert 70 < causes["angular_gain"]["gain"].estimate < 100
    assert causes["linear_gain"]["gain"].estimate == pytest.approx(0.99, abs=0.02)
    assert "gains were fitted first" in findings.notes[0]
    assert findings.extended.robots[0].effects.angular_gain == causes["angular_gain"]["gain"].estimate


@pytest.mark.slow
def test_the_shipped_hero_has_the_measured_actuation() -> None:
    findings, _ = calibrated("hero_2018")
    shipped = load_world("hero").robots[0].effects
    low, high = {cause.effect: cause.parameters for cause in findings.causes}["linear_gain"]["gain"].ci95
    assert low < shipped.linear_gain < high
    # in units of the driver turns are off by far more than any delay; with them right, the delay makes predictions better
    turning = IDEAL.with_effects(linear_gain=shipped.linear_gain, angular_gain=findings.extended.robots[0].effects.angular_gain)
    ideal, late = (evaluate(turning.with_effects(dead_time=delay), findings.log) for delay in (0.0, shipped.dead_time))
    for horizon in ideal:
        assert late[horizon]["position_m"] < ideal[horizon]["position_m"]


@pytest.mark.slow
@pytest.mark.skipif(not STUDY, reason="CALIBRATION_STUDY is not set")
@pytest.mark.parametrize("name", ["hero_2018", "epuck_2018", "create_2009"])
def test_findings_are_stable_when_runs_are_left_out(name: str) -> None:
    findings, _ = calibrated(name)
    stability = leave_one_out(findings.log, findings.spec, findings.causes)
    first = findings.causes[0].effect
    assert stability.named[first] == stability.runs
    for moved in stability.moved:
        if moved.parameter == "gain":
            assert moved.least > 0.7 * moved.estimate
            assert moved.most < 1.3 * moved.estimate


def test_the_bags_hold_what_the_folder_does() -> None:
    pytest.importorskip("rosbags")
    log = read_log(*sorted((MEASURED / "rosbag").glob("*.bag")))
    folder = {track.run: track for track in read_log(MEASURED / "hero_2018").tracks}
    assert len(log.tracks) == 2
    for track in log.tracks:
        known = folder[track.run]
        assert track.robot == known.robot
        assert track.commands == pytest.approx(known.commands, abs=1e-8)
        # the folder counts from the first pose of the tracker, a bag from its own first message
        shift = track.command_times[0] - known.command_times[0]
        inside = (known.times + shift > track.times[0]) & (known.times + shift < track.times[-1])
        for k in range(3):
            there = np.interp(known.times[inside] + shift, track.times, track.poses[:, k])
            assert np.median(np.abs(there - known.poses[inside, k])) < 1e-3


def test_evaluation_of_a_bag_is_that_of_its_run_in_the_folder() -> None:
    pytest.importorskip("rosbags")
    run = "test12_2018-10-21-14-20-44"
    folder = read_log(MEASURED / "hero_2018")
    alone = dataclasses.replace(folder, tracks=tuple(track for track in folder.tracks if track.run == run))
    bag, log = evaluate("hero", MEASURED / "rosbag" / f"{run}.bag"), evaluate("hero", alone)
    for horizon, row in log.items():
        assert bag[horizon]["position_m"] == pytest.approx(row["position_m"], rel=0.05)

"""What a swarm does, before and after: on runs whose world is known."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from swarm_envs import WorldSpec, load_world
from swarm_envs.calibration import calibrate
from swarm_envs.calibration.drive.fitting import Model
from swarm_envs.calibration.drive.measured import measured
from swarm_envs.calibration.drive.parameters import drive_parameters
from swarm_envs.calibration.validation.gain import Gain
from swarm_envs.calibration.validation.swarm import swarm_gain
from swarm_envs.calibration.validation.swarm_runs import controller_of
from tests.calibration.simulated import CONTROLLERS, log_of


def true_world() -> WorldSpec:
    """Robots that see half as far, miss one reading in ten and drive slower than those of hero_plus."""
    world = load_world("hero_plus", num_robots=6).with_effects(linear_gain=0.8, missed_detections=0.1)
    robots = tuple(dataclasses.replace(r, sensors=(dataclasses.replace(r.sensors[0], range=0.5),)) for r in world.robots)
    return world.replace(robots=robots)


@pytest.fixture(scope="module")
def gains() -> dict[str, Gain]:
    before, after = load_world("hero_plus", num_robots=6), true_world()
    log = log_of(after)
    data = measured(log)
    model = Model(drive_parameters(after), np.full(5, 1e-4), np.ones((6, 2)))
    return {gain.metric: gain for gain in swarm_gain(log, data, [model] * len(data.runs), before, after)}


def test_the_true_world_moves_a_swarm_as_it_was_measured(gains: dict[str, Gain]) -> None:
    for name in ("average_speed", "scatter", "group_rotation"):
        assert gains[name].after < 0.2 * gains[name].before, name
        assert gains[name].ci95[0] > 0, name


def test_readings_of_the_true_world_differ_by_chance_alone(gains: dict[str, Gain]) -> None:
    found = gains["detections"]
    assert found.noise_floor is not None
    assert found.after == pytest.approx(found.noise_floor, rel=0.3)
    assert found.before > 2 * found.after


def test_the_controllers_run_in_both_worlds(gains: dict[str, Gain]) -> None:
    assert gains["closed_loop.detection_rate"].after < 0.3 * gains["closed_loop.detection_rate"].before
    assert gains["closed_loop.average_speed"].after < 0.5 * gains["closed_loop.average_speed"].before
    assert 0 <= gains["closed_loop.label"].after <= 1


def test_controllers_are_read_from_commands_that_follow_detections() -> None:
    tracks = [track for track in log_of(true_world()).tracks if track.run == "run_1"]
    assert controller_of(tracks) == pytest.approx(CONTROLLERS[1])
    shuffled = [dataclasses.replace(track, detections=np.roll(track.detections, 37)) for track in tracks]
    assert controller_of(shuffled) is None


def test_readings_of_a_sensor_that_is_late_are_compared_where_both_worlds_know_what_was_in_view() -> None:
    before = load_world("hero_plus", num_robots=6)
    after = before.with_effects(sensor_delay=0.3)
    log = log_of(after)
    data = measured(log)
    model = Model(drive_parameters(after), np.full(5, 1e-4), np.ones((6, 2)))
    gains = {gain.metric: gain for gain in swarm_gain(log, data, [model] * len(data.runs), before, after)}
    # the delay explains all readings, but for corners of a path between two poses
    assert gains["detections"].after < 0.1 * gains["detections"].before


@pytest.mark.slow
def test_a_log_whose_only_effect_is_a_late_sensor_ends_in_findings() -> None:
    world = load_world("hero_plus", num_robots=6)
    findings = calibrate(log_of(world.with_effects(sensor_delay=0.3), steps=120), world)
    assert [cause.effect for cause in findings.causes] == ["sensor_delay"]
    assert findings.extended.robots[0].effects.sensor_delay == pytest.approx(0.3, abs=0.005)
    assert next(gain for gain in findings.gain if gain.metric == "detections").after < 0.01


def test_a_log_of_single_robots_says_nothing_about_swarms() -> None:
    log = log_of(true_world())
    alone = dataclasses.replace(log, tracks=tuple(t for t in log.tracks if t.robot == "robot_0"))
    data = measured(alone)
    model = Model(drive_parameters(true_world()), np.full(5, 1e-4), np.ones((1, 2)))
    assert swarm_gain(alone, data, [model] * len(data.runs), load_world("hero_plus"), true_world()) == []

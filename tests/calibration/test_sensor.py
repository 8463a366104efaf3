"""Effects of the sensor that the world has already are no news."""

from __future__ import annotations

import numpy as np
import pytest

from swarm_envs import load_world
from swarm_envs.calibration.drive.identification import identify
from swarm_envs.calibration.sensor.candidates import EFFECTS, SensorModel
from swarm_envs.calibration.sensor.error_probabilities import miss_probabilities
from swarm_envs.calibration.sensor.identification import identify_sensor
from swarm_envs.simulation.effect_rows import effect_rows
from swarm_envs.worlds import Effects
from tests.calibration.simulated import log_of


def test_misses_while_driving_that_the_world_has_are_not_taken_for_other_misses() -> None:
    world = load_world("hero_plus", num_robots=6).with_effects(misses_when_driving=5.0)
    log = log_of(world)
    drive = identify(log, world)
    assert identify_sensor(log, world, drive).causes == ()
    # a world without them gets the blame for as many misses as there are at the speeds of these runs
    blind = identify_sensor(log, world.with_effects(misses_when_driving=0.0), drive)
    assert "missed_detections" in {cause.effect for cause in blind.causes}


def test_readings_miss_as_often_as_the_law_of_the_sensor_says() -> None:
    effects = Effects(missed_detections=0.1, misses_at_full_range=0.4, misses_when_turning=0.2, misses_when_driving=2.0)
    share, v, omega = np.array([0.0, 0.5, 0.0, 0.0]), np.array([0.0, 0.0, 0.1, 0.0]), np.array([0.0, 0.0, 0.0, 0.3])
    miss = np.empty(4)
    miss_probabilities(effect_rows([effects]), share, v, omega, miss)
    assert miss == pytest.approx([0.1, 0.2, 0.3, 0.16])


def test_units_and_bounds_of_candidates_are_those_of_the_declared_effects() -> None:
    by_name = {effect.name: effect for effect in EFFECTS}
    assert (by_name["sensor_delay"].unit, by_name["sensor_delay"].low, by_name["sensor_delay"].high) == ("s", 0.0, 1.5)
    assert set(by_name) <= set(SensorModel.__dataclass_fields__)

"""The reference learns delays and gains from commands, and only from runs that it does not predict."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from docs.studies.calibration.generator import generate_log
from swarm_envs import load_world
from swarm_envs.calibration import evaluate, read_log
from swarm_envs.calibration.drive.measured import measured
from swarm_envs.calibration.logs.log import Log
from swarm_envs.calibration.prediction.reference import reference_errors

pytest.importorskip("sklearn")

Errors = dict[float, dict[str, float]]
HIDDEN = {"linear_gain": {"gain": 0.8}, "dead_time": {"delay": 0.3}}


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Log:
    folder = tmp_path_factory.mktemp("reference") / "log"
    return read_log(generate_log(HIDDEN, folder, seed=8, runs=5, position_noise=5e-4, heading_noise=2e-3, procedures=["drives"]))


@pytest.fixture(scope="module")
def reference(log: Log) -> Errors:
    return reference_errors(log, measured(log))


def test_it_predicts_far_better_than_a_world_that_knows_nothing_of_the_effects(log: Log, reference: Errors) -> None:
    ideal = evaluate(load_world("hero_plus"), log)
    for horizon in (1.0, 5.0, 10.0):
        assert reference[horizon]["position"] < 0.6 * ideal[f"{horizon:.1f}"]["position_m"]


def test_a_run_is_predicted_by_the_others_alone(log: Log, reference: Errors) -> None:
    """A robot that goes backwards in one run alone is not understood there: had the run been trained on, it would be in part."""
    odd = log.runs[0]
    tracks = tuple(
        dataclasses.replace(track, poses=track.poses[:1] - (track.poses - track.poses[:1]) * np.array([1.0, 1.0, -1.0]))
        if track.run == odd
        else track
        for track in log.tracks
    )
    changed = dataclasses.replace(log, tracks=tracks)
    assert reference_errors(changed, measured(changed), (1.0,))[1.0]["position"] > 3.0 * reference[1.0]["position"]

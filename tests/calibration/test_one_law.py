"""There is one law of motion and one of the sensor: whoever uses one follows when it changes in its one place, and all agree."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

from tests.calibration.changed_law import CHANGES

WAYS = ("disc", "chipmunk", "prediction", "filter")


@pytest.fixture(scope="module")
def ends() -> dict[str, Any]:
    """Where a robot ends up, by changed law, effects and way of moving it."""
    command = [sys.executable, "-W", "ignore", "-m", "tests.calibration.changed_law"]
    ended = subprocess.run(command, env={**os.environ, "NUMBA_DISABLE_JIT": "1"}, capture_output=True, text=True, timeout=240, check=False)
    assert ended.returncode == 0, ended.stderr[-2000:]
    return dict(json.loads(ended.stdout))


@pytest.mark.parametrize("effects", ["ideal", "without lag"])
def test_engines_prediction_and_filter_agree_to_rounding(ends: dict[str, Any], effects: str) -> None:
    # they cut the same arcs at other places and add them up in another order, so sums differ by rounding
    poses = [ends[""][effects][way] for way in WAYS]
    assert np.ptp(poses, axis=0).max() < 1e-14


def test_with_a_lag_they_differ_by_their_time_steps_alone(ends: dict[str, Any]) -> None:
    poses = {way: np.array(ends[""]["with lag"][way]) for way in WAYS}
    assert np.abs(poses["disc"] - poses["chipmunk"]).max() < 1e-14
    assert np.abs(poses["prediction"] - poses["filter"]).max() < 1e-14
    # the engines take the arc of each twentieth of a tick, prediction of half a tick
    assert np.abs(poses["disc"] - poses["prediction"]).max() < 1e-4


@pytest.mark.parametrize("law", CHANGES)
def test_a_law_changed_in_one_place_is_changed_everywhere(ends: dict[str, Any], law: str) -> None:
    for effects, poses in ends[law].items():
        before, after = ([each[way] for way in WAYS] for each in (ends[""][effects], poses))
        assert np.abs(np.subtract(after, before)).max(axis=1).min() > 1e-3, "every way of moving the robot must follow"
        assert np.ptp(after, axis=0).max() < 1e-14, "and in the same way"


@pytest.mark.parametrize(
    ("law", "error", "expected"),
    [
        ("as declared", "missed", 0.3 + 0.4 * 0.25),
        ("changed", "missed", 0.8 - 0.4 * 0.5),
        ("as declared", "false", 0.1),
        ("changed", "false", 0.35),
    ],
)
def test_readings_of_the_simulation_are_wrong_as_often_as_calibration_expects_whatever_the_sensors_law(
    ends: dict[str, Any], law: str, error: str, expected: float
) -> None:
    found = ends["sensor"][law][error]
    assert found["calibration"] == pytest.approx(expected, abs=1e-14)
    assert found["simulation"] == pytest.approx(expected, abs=4 * np.sqrt(expected * (1 - expected) / 2000))

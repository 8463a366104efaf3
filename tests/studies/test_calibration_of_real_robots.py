"""The study of real robots reads delays off a log that are in it."""

from __future__ import annotations

import numpy as np
import pytest

from docs.studies.calibration_of_real_robots.step_responses import Step, onset, response, steps, turns
from docs.studies.calibration_of_real_robots.tables import plain
from swarm_envs import load_world
from swarm_envs.calibration import Log, Track
from swarm_envs.calibration.drive.motion import free_run
from swarm_envs.calibration.drive.parameters import drive_parameters

TIMES = np.arange(0.0, 12.0, 1 / 60)
COMMANDS = [(0.0, 0.0, 0.0), (2.0, 0.05, 0.0), (5.0, 0.0, 0.0), (7.0, 0.0, 0.8), (9.0, 0.0, 0.0)]


def log(delay: float) -> Log:
    """A robot 0.12 rad off the axes that starts, stops and turns late."""
    times, commands = np.array(COMMANDS)[:, 0], np.array(COMMANDS)[:, 1:]
    track = Track("run", "robot", TIMES, np.zeros((len(TIMES), 3)), times, commands, np.empty(0), np.empty(0, bool))
    parameters = drive_parameters(load_world("hero_plus").with_effects(dead_time=delay))
    poses = free_run(parameters, track).from_pose(0, np.array([0.0, 0.0, 0.12]), slice(None))
    noise = np.random.default_rng(0).normal(0, [1e-4, 1e-4, 1e-3], poses.shape)
    return Log("it", (Track("run", "robot", TIMES, poses + noise, times, commands, np.empty(0), np.empty(0, bool)),))


@pytest.mark.parametrize("delay", [0.0, 0.06, 0.12])
def test_the_delay_of_a_start_a_stop_and_a_turn_is_found(delay: float) -> None:
    start, stop = steps(log(delay))
    assert start.starts
    assert not stop.starts
    first, last = turns(log(delay))
    found = [onset(start), onset(stop), onset(first, turning=True), onset(last, turning=True)]
    assert found == pytest.approx([delay] * 4, abs=0.012)


def test_the_response_is_the_speed_over_the_commanded() -> None:
    start: Step = next(steps(log(0.1)))
    speed = response(start, start.track.poses, np.array([-0.5, 0.0, 0.15, 1.0]))
    assert speed == pytest.approx([0.0, 1 / 3, 1.0], abs=0.05)


def test_a_heading_that_flips_has_no_delay() -> None:
    (track,) = log(0.1).tracks
    flipped = track.poses.copy()
    flipped[(TIMES > 6.9) & (TIMES < 7.05), 2] += np.pi
    found = next(turns(Log("it", (Track("run", "robot", TIMES, flipped, *(getattr(track, name) for name in REST)),))))
    assert np.isnan(onset(found, turning=True))


REST = ("command_times", "commands", "detection_times", "detections")


def test_small_numbers_are_written_in_thousandths() -> None:
    assert [plain(value) for value in (14.4, 0.0509, 0.000217, None)] == ["14,400", "50.9", "0.217", ""]

"""The robot's own code at the wheel of simulated robots."""

from __future__ import annotations

import time

import numpy as np
import pytest

from hero_robot.firmware import FirmwareError, FirmwareSwarm, SimulatedBoard, State

RESOLVED = 0.012
"""m/s: a rim this fast gives an encoder edge each 0.13 s, so that its speed is known at all times."""

QUANTA = (0.6e-3, 0.018)
"""m/s and rad/s, at each tick: half a microsecond of servo pulse is 0.53 mm/s of rim, on two wheels over the wheel base."""

MEANS = (0.1e-3, 2e-3)
"""m/s and rad/s, in the mean over four seconds: the loop hunts between two pulses around the wanted speed."""

CREEPING = (3e-3, 0.1)
"""m/s and rad/s, where a wheel creeps below RESOLVED: with edges further apart than the loop's memory the feed-forward decides."""


def steady(swarm: FirmwareSwarm, seen: int, steps: int = 100) -> np.ndarray:
    """Motion (40, R, 2) after six seconds, six times the loop's integral time."""
    detections = np.full(len(swarm.boards), seen, dtype=np.uint8)
    return np.array([swarm.step(detections, 0.1) for _ in range(steps)])[60:]


def if_else(controller: np.ndarray, seen: int) -> np.ndarray:
    return controller[2:] if seen else controller[:2]


def slowest_rim(motion: np.ndarray) -> float:
    return float(min(abs(motion[0] - motion[1] * 0.0315), abs(motion[0] + motion[1] * 0.0315)))


@pytest.mark.parametrize("seed", range(40))
def test_steady_commands_equal_the_if_else_controller_within_quantisation(seed: int) -> None:
    random = np.random.default_rng(seed)
    controller = random.uniform([-0.09, -1.6, -0.09, -1.6], [0.09, 1.6, 0.09, 1.6])
    swarm = FirmwareSwarm("hero_plus", 4, controller, seed=seed)
    swarm.reset()
    for seen in (0, 1, 0):
        expected = if_else(controller, seen)
        off = steady(swarm, seen) - expected
        if slowest_rim(expected) < RESOLVED:
            assert (np.abs(off) < CREEPING).all()
        else:
            assert (np.abs(off) < QUANTA).all()
            assert (np.abs(off.mean(axis=0)) < MEANS).all()


@pytest.mark.parametrize("seed", range(5))
def test_the_motion_asked_for_equals_the_if_else_controller_to_a_unit_in_the_last_place(seed: int) -> None:
    controller = np.random.default_rng(seed).uniform([-0.2, -3, -0.2, -3], [0.2, 3, 0.2, 3])
    swarm = FirmwareSwarm("hero_plus", 1, controller)
    swarm.reset()
    for seen in (0, 1):
        steady(swarm, seen, 25)
        np.testing.assert_allclose(swarm.boards[0].view().command, if_else(controller, seen), rtol=0, atol=1 / 65536)


def test_a_detection_turns_the_robot_within_two_ticks() -> None:
    swarm = FirmwareSwarm("hero_plus", 1, (0.08, 0.4, 0.05, -1.2))
    swarm.reset()
    steady(swarm, 0)
    swarm.step([1], 0.1)
    assert swarm.step([1], 0.1)[0, 1] < -0.8


def test_the_same_calls_give_the_same_bits() -> None:
    detections = np.random.default_rng(0).integers(0, 2, (50, 8))
    runs = []
    for _ in range(2):
        swarm = FirmwareSwarm("hero_plus", 8, (0.08, 0.4, 0.05, -1.2), seed=3)
        swarm.reset()
        swarm.step(detections[0], 0.1)
        swarm.reset()
        runs.append(np.array([swarm.step(row, 0.1) for row in detections]))
    assert (runs[0] == runs[1]).all()


def test_odometry_follows_the_wheels_over_a_minute() -> None:
    swarm = FirmwareSwarm("hero_plus", 1, (0.08, 0.5, 0.08, -0.5))
    swarm.reset()
    board = swarm.boards[0]
    before = board.view()
    for step in range(600):
        swarm.step([step // 100 % 2], 0.1)
    view = board.view()
    turned = (view.path[1] - before.path[1] - view.path[0] + before.path[0]) / 0.063
    believed = (view.heading - before.heading) / 2**32 * 2 * np.pi
    assert abs((believed - turned + np.pi) % (2 * np.pi) - np.pi) < 0.1  # four ticks
    assert sum(view.edges) == pytest.approx(sum(view.path) / 0.00161007, abs=8)


def test_calibrated_halts_are_used() -> None:
    board = SimulatedBoard(3, bytes(32), 0)
    board.set_halts(1493, 1448)
    assert board.start((0.08, 0.0, 0.08, 0.0))
    board.run(0.1)
    left, right = board.view().pulse_us
    assert left > 1493 + 50
    assert right < 1448 - 50


def test_a_robot_held_fast_stalls_into_fault() -> None:
    swarm = FirmwareSwarm("hero_plus", 2, (0.08, 0.0, 0.08, 0.0))
    swarm.reset()
    motion = np.zeros((2, 2))
    for _ in range(80):
        motion[1] = swarm.step([0, 0], 0.1, motion=motion)[1]
    assert swarm.boards[0].view().state == State.FAULT
    assert swarm.boards[1].view().state == State.RUN


def test_distances_pass_the_threshold_of_the_sensor() -> None:
    swarm = FirmwareSwarm("hero_plus", 3, (0.08, 0.0, 0.0, 1.0))
    swarm.reset()
    for _ in range(10):
        swarm.step([], 0.1, distances=[0.99, 1.01, np.inf])
    assert [board.view().seen for board in swarm.boards] == [True, False, False]


def test_long_ticks_keep_the_lease() -> None:
    swarm = FirmwareSwarm("hero_plus", 1, (0.08, 0.0, 0.08, 0.0))
    swarm.reset()
    assert swarm.step([0], 2.0)[0, 0] == pytest.approx(0.08, abs=0.003)


@pytest.mark.parametrize("controllers", [(0.3, 0, 0, 0), (0, 0, 0, 3.1), (np.nan, 0, 0, 0)])
def test_a_controller_beyond_the_limits_is_refused(controllers: tuple[float, ...]) -> None:
    with pytest.raises(FirmwareError, match="beyond"):
        FirmwareSwarm("hero_plus", 2, controllers)


def test_a_wrong_number_of_controllers_is_refused() -> None:
    with pytest.raises(FirmwareError, match=r"expected \(4,\) or \(8, 4\)"):
        FirmwareSwarm("hero_plus", 8, np.zeros((7, 4)))


def test_eight_robots_run_fifty_times_faster_than_time() -> None:
    swarm = FirmwareSwarm("hero_plus", 8, (0.08, 0.4, 0.05, -1.2))
    swarm.reset()
    start = time.process_time()
    for _ in range(300):
        swarm.step(np.zeros(8), 0.1)
    assert time.process_time() - start < 0.6  # thirty seconds of eight robots; 0.04 s on an idle core

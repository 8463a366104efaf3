"""Prediction inside the outline that a log gives: walls and other robots hold robots up."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from swarm_envs import Simulation, WorldSpec, load_world
from swarm_envs.calibration import Log, LogError, Track, evaluate

SIDE = 0.6
SQUARE = ((0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE))


def world_in(outline: tuple[tuple[float, float], ...], robots: int, **effects: float) -> WorldSpec:
    world = load_world("hero_plus", num_robots=1).with_effects(**effects)
    return world.replace(arena=dataclasses.replace(world.arena, outline=outline)).with_robots(robots)


def driven(world: WorldSpec, start: list[list[float]], commands: list[tuple[float, float]], seconds: float = 15.0) -> tuple[Track, ...]:
    """Robots that keep one command each."""
    simulation = Simulation(world)
    simulation.reset(0, initial_poses=np.array([start]))
    poses = [simulation.poses[0].copy()]
    for _ in range(round(10 * seconds)):
        simulation.step(np.array([commands]))
        poses.append(simulation.poses[0].copy())
    times, path = 0.1 * np.arange(len(poses)), np.array(poses)
    none = (np.empty(0), np.empty(0, bool))
    return tuple(Track("run", f"robot_{i}", times, path[:, i], np.zeros(1), np.array([c]), *none) for i, c in enumerate(commands))


def test_a_robot_at_a_wall_is_predicted_to_stay_there() -> None:
    world = world_in(SQUARE, 1)
    log = Log("it", driven(world, [[0.3, 0.3, 0.4]], [(0.08, 0.0)]), outline=SQUARE)
    inside = evaluate(world, log)["10.0"]
    assert inside["position_m"] < 2e-3
    assert inside["heading_rad"] < 0.02
    assert evaluate(world, dataclasses.replace(log, outline=None))["10.0"]["position_m"] > 0.3


def test_robots_that_push_each_other_are_predicted_together() -> None:
    wide = ((-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0))
    world = world_in(wide, 2)
    log = Log("it", driven(world, [[0.0, 0.0, 0.0], [0.2, 0.01, 1.0]], [(0.08, 0.0), (0.0, 0.0)]), outline=wide)
    assert evaluate(world, log)["5.0"]["position_m"] < 2e-3
    assert evaluate(world, dataclasses.replace(log, outline=None))["5.0"]["position_m"] > 0.05


@pytest.mark.parametrize("effects", [{}, {"dead_time": 0.2, "motor_lag": 0.2, "floor_drift_x": 0.01, "turn_bias": 0.5}])
def test_walls_that_nobody_meets_change_nothing(effects: dict[str, float]) -> None:
    wide = ((-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0))
    log = Log("it", driven(world_in(wide, 1), [[0.0, 0.0, 0.0]], [(0.08, 0.3)]), outline=wide)
    world = world_in(wide, 1, **effects)
    inside, alone = evaluate(world, log), evaluate(world, dataclasses.replace(log, outline=None))
    for horizon, row in alone.items():
        assert inside[horizon]["position_m"] == pytest.approx(row["position_m"], abs=1e-3)
        assert inside[horizon]["heading_rad"] == pytest.approx(row["heading_rad"], abs=1e-6)


def test_a_robot_that_was_lost_for_a_while_is_left_out_of_the_windows_then() -> None:
    world = world_in(SQUARE, 1)
    (track,) = driven(world, [[0.3, 0.3, 0.4]], [(0.08, 0.0)])
    seen = (track.times < 5.0) | (track.times > 8.0)
    log = Log("it", (dataclasses.replace(track, times=track.times[seen], poses=track.poses[seen]),), outline=SQUARE)
    assert evaluate(world, log)["1.0"]["windows"] < evaluate(world, Log("it", (track,), outline=SQUARE))["1.0"]["windows"] - 4


def test_an_outline_that_the_poses_leave_is_refused() -> None:
    world = world_in(SQUARE, 1)
    tracks = driven(world, [[0.3, 0.3, 0.4]], [(0.08, 0.0)])
    elsewhere = tuple((x + 5.0, y) for x, y in SQUARE)
    with pytest.raises(LogError, match=r"it: 100% of the poses of robot_0 in run lie outside the outline"):
        evaluate(world, Log("it", tracks, outline=elsewhere))
    crossed = ((0.0, 0.0), (SIDE, SIDE), (SIDE, 0.0), (0.0, SIDE))
    with pytest.raises(LogError, match=r"outline: .*not a simple polygon"):
        evaluate(world, Log("it", tracks, outline=crossed))

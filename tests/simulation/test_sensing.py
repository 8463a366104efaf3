"""Detections against brute-force geometry, and each sensing effect at the asked rate."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from swarm_envs import Simulation, load_world
from swarm_envs.worlds import Sensor, WorldSpec


def sampled_sector_hits(relative: np.ndarray, half_angle: float, reach: float, radius: float) -> np.ndarray:
    """Whether discs at ``relative`` (N, 2) in the sensor's frame meet the sector, by sampling the sector's two edges and its inside.

    Independent of the closed form: the distance from a disc's centre to the sector is the least over the directions in it.
    """
    angles = np.linspace(-half_angle, half_angle, 181)
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    along = np.maximum(relative @ directions.T, 0.0)
    squared = (relative**2).sum(axis=1)[:, None] - along**2
    return (squared.min(axis=1) <= radius**2) & (np.hypot(*relative.T) <= reach)


def pairs(world: WorldSpec, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Readings of robot 0 for ``count`` random placements of two robots, and the other's place in its frame."""
    generator = np.random.default_rng(seed)
    simulation = Simulation(world, count, "disc")
    poses = simulation.poses
    poses[:, 0] = [5.0, 5.0, 0.0]
    poses[:, 0, 2] = generator.uniform(-7, 7, count)
    distance, bearing = generator.uniform(0.0, 1.3, count), generator.uniform(-np.pi, np.pi, count)
    bearing[: count // 2] *= 0.1
    poses[:, 1, 0] = 5.0 + distance * np.cos(bearing + poses[:, 0, 2])
    poses[:, 1, 1] = 5.0 + distance * np.sin(bearing + poses[:, 0, 2])
    simulation.observe()
    return simulation.detections[:, 0].astype(bool), np.stack([distance * np.cos(bearing), distance * np.sin(bearing)], axis=1)


def big(world: WorldSpec) -> WorldSpec:
    outline = ((0.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0))
    return dataclasses.replace(world, arena=dataclasses.replace(world.arena, outline=outline))


def with_sensors(world: WorldSpec, *sensors: Sensor) -> WorldSpec:
    return dataclasses.replace(world, robots=tuple(dataclasses.replace(robot, sensors=sensors) for robot in world.robots))


@pytest.mark.parametrize("half_angle", [0.0, 0.12, 0.8, 1.5, 2.6, np.pi])
def test_detections_match_brute_force_geometry_on_a_million_pairs(half_angle: float) -> None:
    world = with_sensors(big(load_world("hero_plus", num_robots=2)), Sensor(half_angle, 1.0))
    for seed in range(2):
        seen, relative = pairs(world, 84_000, seed)
        expected = sampled_sector_hits(relative, half_angle, 1.0, 0.04)
        # sampled directions leave slivers between them: look only at discs that are not within 0.1 mm of the sector's edge
        clear = sampled_sector_hits(relative, half_angle, 1.0, 0.0401) == sampled_sector_hits(relative, half_angle, 1.0, 0.0399)
        assert clear.mean() > 0.99
        assert (seen == expected)[clear].all()
    assert 0.01 < seen.mean() < 0.99 or half_angle == np.pi


def test_a_robot_beyond_the_range_is_not_seen_and_one_just_inside_is() -> None:
    world = big(load_world("hero_plus", num_robots=2))
    simulation = Simulation(world, 2, "disc")
    simulation.poses[:, 0] = [5, 5, 0]
    simulation.poses[:, 1] = [[5.999, 5, 0], [6.001, 5, 0]]
    simulation.observe()
    assert simulation.detections[:, 0].tolist() == [1, 0]


def test_the_sensor_does_not_see_walls() -> None:
    simulation = Simulation(load_world("hero_plus", num_robots=1), 50, "disc")
    simulation.reset(0)
    for _ in range(100):
        simulation.step(np.tile([0.09, 0.0], (50, 1, 1)))
        assert not simulation.detections.any()


def test_a_large_swarm_senses_like_a_small_one() -> None:
    """The grid search of many robots gives what looking at every pair gives."""
    world = load_world("hero_plus").with_robots(200, scale_arena=True)
    simulation = Simulation(world, 1, "disc")
    simulation.reset(3)
    poses = simulation.poses[0]
    relative = poses[None, :, :2] - poses[:, None, :2]
    c, s = np.cos(poses[:, 2])[:, None], np.sin(poses[:, 2])[:, None]
    along, across = c * relative[..., 0] + s * relative[..., 1], -s * relative[..., 0] + c * relative[..., 1]
    inside = (np.abs(across) * np.cos(0.12) - along * np.sin(0.12) <= 0.04) & (along > 0.0) & (np.hypot(along, across) <= 1.0)
    np.fill_diagonal(inside, False)
    assert simulation.detections[0].tolist() == inside.any(axis=1).astype(int).tolist()


def facing_pair(**effects: float) -> Simulation:
    """1,000 worlds of two robots face to face, 0.5 m apart."""
    world = load_world("hero_plus", num_robots=2).with_effects(**effects)
    simulation = Simulation(world, 1000, "disc")
    simulation.reset(5, initial_poses=np.tile([[0.6, 0.7, 0.0], [1.1, 0.7, np.pi]], (1000, 1, 1)))
    return simulation


def reading_rate(simulation: Simulation, command: tuple[float, float], ticks: int = 20) -> float:
    seen = []
    for _ in range(ticks):
        simulation.step(np.tile(command, (1000, 2, 1)))
        seen.append(simulation.detections.mean())
    return float(np.mean(seen))


def test_missed_detections_come_at_the_asked_rate() -> None:
    assert reading_rate(facing_pair(missed_detections=0.3), (0, 0)) == pytest.approx(0.7, abs=0.01)


def test_misses_rise_with_distance_to_the_asked_rate() -> None:
    assert reading_rate(facing_pair(misses_at_full_range=0.4), (0, 0)) == pytest.approx(1 - 0.4 * 0.25, abs=0.01)


def test_misses_rise_with_turning_and_driving() -> None:
    assert reading_rate(facing_pair(misses_when_turning=2.0), (0.0, 0.1), 1) == pytest.approx(0.8, abs=0.03)
    assert reading_rate(facing_pair(misses_when_driving=5.0), (0.05, 0.0), 2) == pytest.approx(0.75, abs=0.03)


def test_false_detections_come_only_where_nothing_is_in_view() -> None:
    world = load_world("hero_plus", num_robots=2).with_effects(false_detections=0.2)
    simulation = Simulation(world, 1000, "disc")
    simulation.reset(5, initial_poses=np.tile([[0.6, 0.7, np.pi], [1.1, 0.7, 0.0]], (1000, 1, 1)))
    assert reading_rate(simulation, (0, 0)) == pytest.approx(0.2, abs=0.01)


def test_a_delayed_sensor_reports_the_past() -> None:
    world = load_world("hero_plus", num_robots=2)
    start = np.array([[[0.6, 0.7, -0.4], [1.1, 0.7, np.pi / 2]]])
    prompt, late = Simulation(world, 1, "disc"), Simulation(world.with_effects(sensor_delay=0.3), 1, "disc")
    histories: list[list[int]] = []
    for simulation in (prompt, late):
        simulation.reset(0, initial_poses=start)
        histories.append([int(simulation.detections[0, 0])])
        for _ in range(30):
            simulation.step([[[0.0, 0.5], [0.0, 0.0]]])
            histories[-1].append(int(simulation.detections[0, 0]))
    assert 0 < sum(histories[0]) < 30
    assert histories[1][3:] == histories[0][:-3]
    assert histories[1][:3] == [0, 0, 0]


def test_a_slow_sensor_holds_its_reading_between_periods() -> None:
    world = with_sensors(load_world("hero_plus", num_robots=2), Sensor(0.12, 1.0, period=0.4))
    simulation = Simulation(world, 1, "disc")
    simulation.reset(0, initial_poses=np.array([[[0.6, 0.7, -0.4], [1.1, 0.7, np.pi / 2]]]))
    readings = []
    for _ in range(40):
        readings.append(int(simulation.detections[0, 0]))
        simulation.step([[[0.0, 0.37], [0.0, 0.0]]])
    changes = np.flatnonzero(np.diff(readings)) + 1
    assert len(changes) >= 2
    assert (changes % 4 == 0).all()


def test_a_yawed_sensor_looks_aside_and_a_second_sensor_looks_back() -> None:
    world = load_world("hero_plus", num_robots=2)
    two = with_sensors(world, Sensor(0.12, 1.0), Sensor(0.12, 1.0, bearing=np.pi))
    simulation = Simulation(two, 1, "chipmunk")
    simulation.reset(0, initial_poses=np.array([[[0.6, 0.7, 0.0], [1.1, 0.7, 0.0]]]))
    assert simulation.detections[0].tolist() == [[1, 0], [0, 1]]
    yawed = Simulation(world.with_effects(sensor_yaw=0.5), 1, "disc")
    yawed.reset(0, initial_poses=np.array([[[0.6, 0.7, -0.5], [1.1, 0.7, 0.0]]]))
    assert yawed.detections[0].tolist() == [1, 0]

"""Metrics against closed forms and plain loops."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import numpy.typing as npt
import pytest

from swarm_envs import Trajectories, load_world, metrics
from swarm_envs.worlds import Obstacle, WorldSpec

HERO = load_world("hero_plus")
RADIUS = math.hypot(1.70, 1.42) / 2


def runs(poses: npt.ArrayLike, every: int = 1, world: WorldSpec = HERO) -> Trajectories:
    """Trajectories of given poses (worlds, frames, robots, 3), recorded each ``every`` ticks."""
    array = np.asarray(poses, dtype=np.float64)
    time = np.arange(array.shape[1]) * every * world.tick
    shape = array.shape[:3]
    return Trajectories(world, "constructed", time, array, np.zeros(shape, np.uint8), np.zeros((*shape, 2)))


def ring(
    radius: float, turn_rate: float, frames: int = 301, every: int = 1, robots: int = 8, centre: tuple[float, float] = (0.85, 0.71)
) -> Trajectories:
    """Robots evenly spaced on a circle, revolving."""
    angle = 2 * np.pi * np.arange(robots) / robots + turn_rate * 0.1 * every * np.arange(frames)[:, None]
    heading = angle + np.pi / 2 * np.sign(turn_rate)
    return runs(np.stack([centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle), heading], axis=-1)[None], every)


def random_walks(seed: int = 0, worlds: int = 3, frames: int = 120, robots: int = 8) -> Trajectories:
    rng = np.random.default_rng(seed)
    start = np.concatenate(
        [rng.uniform([0.2, 0.2], [1.5, 1.2], (worlds, 1, robots, 2)), rng.uniform(0, 6, (worlds, 1, robots, 1))], axis=-1
    )
    return runs(start + np.cumsum(rng.normal(0, 0.005, (worlds, frames, robots, 3)), axis=1))


@pytest.mark.parametrize("sense", [1, -1])
def test_a_revolving_ring_has_the_closed_form_of_all_five_measures(sense: int) -> None:
    radius, rate = 0.4, 0.2
    chord_speed = 2 * radius * math.sin(rate * 0.1 / 2) / 0.1
    across = -sense * radius * math.sin(rate * 0.1) / 0.1  # v x arm, with v the backward difference: the chord, seen from its end
    expected = [chord_speed, across * radius / RADIUS, 0.0, radius**2 / RADIUS**2, across]
    np.testing.assert_allclose(metrics.hand_crafted(ring(radius, sense * rate))[0], expected, atol=1e-12)


def test_hand_crafted_equals_plain_loops_over_random_walks() -> None:
    trajectories = random_walks()
    measured = metrics.hand_crafted(trajectories)
    assert measured.shape == (3, 5)
    for world, poses in enumerate(trajectories.poses):
        sums = np.zeros(5)
        for now in range(20, 120):
            positions, before = poses[now, :, :2], poses[now - 1, :, :2]
            centre = sum(positions) / 8
            distances = [math.dist(p, centre) for p in positions]
            mean_distance = sum(distances) / 8
            for p, old, d in zip(positions, before, distances, strict=True):
                v = (p - old) / 0.1
                cross = v[0] * (p - centre)[1] - v[1] * (p - centre)[0]
                terms = [math.hypot(*v), cross / RADIUS, (d - mean_distance) ** 2 / (0.15 * RADIUS**2), d**2 / RADIUS**2, cross / d]
                sums += np.array(terms) / 800
        np.testing.assert_allclose(measured[world], sums, rtol=1e-9, atol=1e-12)


def test_a_lone_motionless_robot_and_robots_in_one_point_give_finite_measures() -> None:
    alone = runs(np.full((1, 50, 1, 3), 0.5))
    crowd = runs(np.full((1, 50, 8, 3), 0.5))
    np.testing.assert_array_equal(metrics.hand_crafted(alone), 0)
    np.testing.assert_array_equal(metrics.hand_crafted(crowd), 0)
    assert metrics.convex_hull_area(alone)[0] == 0
    assert np.isinf(metrics.nearest_neighbour_distance(alone)[0])


def test_the_last_hundred_ticks_are_the_same_span_when_every_fifth_tick_is_recorded() -> None:
    poses = np.zeros((1, 121, 2, 3))
    poses[0, :, 0, 0] = 0.5 + 0.08 * np.arange(121) * 0.5
    poses[0, :101, 0, 0] = 0.5  # at rest until 20 ticks x 5 before the end
    assert metrics.average_speed(runs(poses, every=5))[0] == pytest.approx(np.abs(np.diff(poses[0, 100:, 0, 0])).sum() / 10 / 2)


def test_a_run_shorter_than_the_window_is_measured_over_all_its_steps() -> None:
    assert metrics.average_speed(ring(0.3, 0.3, frames=5))[0] == pytest.approx(0.09, rel=1e-3)


def test_a_single_frame_is_refused_with_what_to_do() -> None:
    with pytest.raises(ValueError, match=r"1 frame.*at least 2"):
        metrics.hand_crafted(ring(0.3, 0.3, frames=1))


def test_hull_neighbours_and_polarization_of_a_ring_are_those_of_a_regular_polygon() -> None:
    trajectories = ring(0.4, 0.2)
    assert metrics.convex_hull_area(trajectories)[0] == pytest.approx(8 / 2 * 0.4**2 * math.sin(2 * math.pi / 8))
    assert metrics.nearest_neighbour_distance(trajectories)[0] == pytest.approx(2 * 0.4 * math.sin(math.pi / 8))
    assert metrics.polarization(trajectories)[0] == pytest.approx(0, abs=1e-9)
    aligned = trajectories.poses.copy()
    aligned[..., 2] = 1.0
    assert metrics.polarization(runs(aligned))[0] == pytest.approx(1)


def test_contacts_are_those_of_touching_discs_and_walls() -> None:
    poses = np.array(
        [[0.3, 0.3, 0], [0.4209, 0.3, 0], [0.8, 0.7, 0], [0.9, 0.9, 0], [1.64, 0.7, 0], [0.5, 0.059, 0], [1.3, 1.0, 0], [1.2, 0.4, 0]]
    )
    expected = [True, True, False, False, True, True, False, False]
    np.testing.assert_array_equal(metrics.in_contact(HERO, poses), expected)
    np.testing.assert_array_equal(metrics.at_wall(HERO, poses), [False, False, False, False, True, True, False, False])
    assert metrics.collisions(runs(np.tile(poses, (1, 10, 1, 1))))[0] == pytest.approx(0.5)


def test_obstacles_are_walls() -> None:
    arena = dataclasses.replace(HERO.arena, obstacles=(Obstacle(((0.8, 0.6), (1.0, 0.6), (1.0, 0.8), (0.8, 0.8))),))
    world = HERO.replace(arena=arena)
    poses = np.tile([0.2, 0.2, 0.0], (8, 1)) + np.arange(8)[:, None] * [0.13, 0, 0]
    poses[7] = [0.74, 0.7, 0]
    np.testing.assert_array_equal(metrics.at_wall(world, poses), [False] * 7 + [True])


def test_coverage_of_still_robots_is_their_discs_and_of_a_sweep_its_strip() -> None:
    poses = np.full((2, 90, 8, 3), -5.0)  # robots outside the arena cover nothing
    poses[0, :, :, 0], poses[0, :, :, 1] = np.linspace(0.3, 1.4, 8) + 0.003 * np.arange(8), np.linspace(0.31, 1.1, 8)
    poses[1, :, 0, 0], poses[1, :, 0, 1] = np.linspace(0.4, 1.2, 90), 0.7
    disc = math.pi * 0.06**2
    np.testing.assert_allclose(metrics.coverage(runs(poses)), np.array([8 * disc, disc + 0.8 * 0.12]) / (1.70 * 1.42), rtol=0.03)


def test_metrics_do_not_depend_on_the_order_of_robots_nor_on_what_else_is_in_the_batch() -> None:
    trajectories = random_walks(worlds=4)
    shuffled = runs(trajectories.poses[:, :, ::-1])
    for measure in (
        metrics.hand_crafted,
        metrics.convex_hull_area,
        metrics.nearest_neighbour_distance,
        metrics.collisions,
        metrics.coverage,
    ):
        np.testing.assert_allclose(measure(shuffled), measure(trajectories), rtol=1e-9, atol=1e-12)
        np.testing.assert_array_equal(measure(trajectories[2:3]), measure(trajectories)[2:3])

"""Labels on ideal trajectories of every class, their invariance, and on known controllers."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest

from swarm_envs import Trajectories, behaviours, load_world, rollouts
from swarm_envs.worlds import WorldSpec

HERO = load_world("hero_plus")
FRAMES = 601
TIME = 0.1 * np.arange(FRAMES)
Paths = npt.NDArray[np.float64]


def runs(positions: Paths, world: WorldSpec = HERO) -> Trajectories:
    """Trajectories of one world from positions (frames, robots, 2), headings along the motion."""
    velocity = np.gradient(positions, axis=0)
    poses = np.concatenate([positions, np.arctan2(velocity[..., 1], velocity[..., 0])[..., None]], axis=-1)[None]
    shape = poses.shape[:3]
    return Trajectories(world, "constructed", TIME[: len(positions)], poses, np.zeros(shape, np.uint8), np.zeros((*shape, 2)))


def around(centre: tuple[float, float], radius: Paths | float, angle: Paths) -> Paths:
    return np.stack([centre[0] + radius * np.cos(angle), centre[1] + radius * np.sin(angle)], axis=-1)


def still(points: npt.ArrayLike) -> Paths:
    return np.tile(np.asarray(points, dtype=np.float64), (FRAMES, 1, 1))


def heap() -> Paths:
    lattice = [(i + j / 2, j * 3**0.5 / 2) for j in range(3) for i in range(3)][:8]
    return still(np.array(lattice) * 0.121 + [0.7, 0.6])


def pursuit() -> Paths:
    return around((0.8, 0.7), 0.3, 2 * np.pi * np.arange(8) / 8 + 0.25 * TIME[:, None])


def mill() -> Paths:
    radii = np.array([0.08, 0.15, 0.2, 0.25, 0.3, 0.34, 0.38, 0.42])
    return around((0.85, 0.71), radii, 2.4 * np.arange(8) + 0.3 * TIME[:, None])


def spread_out() -> Paths:
    places = [(0.25, 0.25), (0.85, 0.25), (1.45, 0.25), (0.5, 0.71), (1.2, 0.71), (0.25, 1.17), (0.85, 1.17), (1.45, 1.17)]
    return still(places) + 0.03 * np.stack([np.cos(TIME), np.sin(TIME)], axis=-1)[:, None]


def patrol() -> Paths:
    corners = np.array([[0.065, 0.065], [1.635, 0.065], [1.635, 1.355], [0.065, 1.355], [0.065, 0.065]])
    ends = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(corners, axis=0).T))])
    place = (0.08 * TIME[:, None] + np.arange(8) * ends[-1] / 8) % ends[-1]
    return np.stack([np.interp(place, ends, corners[:, axis]) for axis in range(2)], axis=-1)


def grid() -> Paths:
    return still([(0.4 + 0.3 * i, 0.5 + 0.27 * j) for j in range(2) for i in range(4)])


IDEAL: dict[str, Callable[[], Paths]] = {
    "aggregation": heap,
    "cyclic pursuit": pursuit,
    "dispersal": spread_out,
    "milling": mill,
    "wall following": patrol,
    "random": grid,
}


@pytest.mark.parametrize("name", behaviours.LABELS)
def test_an_ideal_swarm_of_each_class_has_its_label(name: str) -> None:
    assert behaviours.label(runs(IDEAL[name]())) == [name]


@pytest.mark.parametrize("name", behaviours.LABELS)
def test_labels_do_not_change_when_the_swarm_is_turned_mirrored_or_renumbered(name: str) -> None:
    paths, size = IDEAL[name](), np.array([1.70, 1.42])
    arena = dataclasses.replace(HERO.arena, outline=((0.0, 0.0), (1.42, 0.0), (1.42, 1.70), (0.0, 1.70)))
    turned = np.stack([size[1] - paths[..., 1], paths[..., 0]], axis=-1)
    assert behaviours.label(runs(size - paths)) == [name]
    assert behaviours.label(runs(paths * [-1, 1] + [size[0], 0])) == [name]
    assert behaviours.label(runs(turned, HERO.replace(arena=arena))) == [name]
    assert behaviours.label(runs(np.random.default_rng(0).permutation(paths, axis=1))) == [name]


@pytest.mark.parametrize("name", behaviours.LABELS)
def test_labels_do_not_change_when_robots_arena_and_speeds_are_three_times_as_large(name: str) -> None:
    bodies = [dataclasses.replace(r, body=dataclasses.replace(r.body, contact_radius=0.18, visible_radius=0.12)) for r in HERO.robots]
    outline = tuple((3 * x, 3 * y) for x, y in HERO.arena.outline)
    large = HERO.replace(
        robots=tuple(bodies),
        arena=dataclasses.replace(HERO.arena, outline=outline),
        limits=dataclasses.replace(HERO.limits, linear_speed=0.27),
    )
    assert behaviours.label(runs(3 * IDEAL[name](), large)) == [name]


def test_an_arena_away_from_the_origin_changes_nothing() -> None:
    outline = tuple((x + 5, y - 3) for x, y in HERO.arena.outline)
    world = HERO.replace(arena=dataclasses.replace(HERO.arena, outline=outline))
    for name, ideal in IDEAL.items():
        assert behaviours.label(runs(ideal() + np.array([5, -3]), world)) == [name]


def test_what_happened_before_the_last_part_does_not_count() -> None:
    paths = pursuit()
    paths[:300] = grid()[:300]
    assert behaviours.label(runs(paths)) == ["cyclic pursuit"]


def test_robots_pressed_against_the_walls_neither_follow_them_nor_disperse() -> None:
    pressed = [(0.06, 0.3), (0.06, 0.9), (0.4, 0.06), (1.0, 0.06), (1.64, 0.4), (1.64, 1.0), (0.5, 1.36), (1.2, 1.36)]
    assert behaviours.label(runs(still(pressed))) == ["random"]


def test_robots_that_shuttle_along_the_wall_do_not_follow_it() -> None:
    to_and_fro = still(patrol()[0])
    to_and_fro += 0.08 * np.sin(TIME)[:, None, None] * np.where(np.isin(to_and_fro[..., :1], [0.065, 1.635]), [[0, 1]], [[1, 0]])
    assert behaviours.label(runs(to_and_fro)) != ["wall following"]


def test_a_swarm_that_stands_on_a_circle_does_not_pursue() -> None:
    assert behaviours.label(runs(still(pursuit()[0]))) == ["random"]


def test_neighbours_that_revolve_in_opposite_senses_neither_pursue_nor_mill() -> None:
    sense = np.array([1, -1] * 4)
    paths = around((0.85, 0.71), np.linspace(0.25, 0.6, 8), np.arange(8) + sense * 0.2 * TIME[:, None])
    assert behaviours.label(runs(paths)) == ["random"]


def test_scores_say_how_near_the_border_a_swarm_is() -> None:
    def score(radius: float) -> float:
        ring = around((0.85, 0.71), np.array([0.3, radius] * 4), 2 * np.pi * np.arange(8) / 8 + 0.2 * TIME[:, None])
        return float(behaviours.scores(behaviours.features(runs(ring)))["cyclic pursuit"][0])

    assert score(0.3) > score(0.25) > score(0.2) > 0 > score(0.12)


def test_a_batch_gives_what_its_worlds_give_alone() -> None:
    controllers = np.random.default_rng(3).uniform([-0.09, -1.6] * 2, [0.09, 1.6] * 2, (300, 4))
    batch = rollouts("hero_plus", controllers, seed=5, record_every=5)
    labels = behaviours.label(batch)
    assert labels[250:] == behaviours.label(batch[250:])
    assert {"aggregation", "cyclic pursuit", "dispersal", "random"} <= set(labels)


@pytest.mark.parametrize(
    ("controller", "expected"),
    [
        ((0.07, -1.3, 0.06, 1.1), "cyclic pursuit"),
        ((0.09, 0.8, 0.09, -0.8), "cyclic pursuit"),
        ((-0.09, -1.2, 0.0, -1.6), "aggregation"),
        ((0.07, 1.4, -0.07, 0.8), "dispersal"),
        ((0.0, 0.0, 0.0, 0.0), "random"),
        ((0.0, 1.0, 0.0, 1.0), "random"),
        ((0.06, 1.0, 0.06, 1.0), "random"),
        ((0.09, 0.0, 0.09, 0.0), "random"),
    ],
)
def test_known_controllers_have_their_label_from_every_start(controller: tuple[float, ...], expected: str) -> None:
    assert behaviours.label(rollouts("hero_plus", [controller] * 10, seed=11)) == [expected] * 10


def test_most_random_controllers_keep_their_label_when_the_seed_changes() -> None:
    controllers = np.random.default_rng(8).uniform([-0.09, -1.6] * 2, [0.09, 1.6] * 2, (300, 4))
    first, second = (behaviours.label(rollouts("hero_plus", controllers, seed=seed, record_every=5)) for seed in (1, 2))
    assert np.mean([a == b for a, b in zip(first, second, strict=True)]) > 0.7


def test_too_few_frames_are_refused_with_the_reason() -> None:
    with pytest.raises(ValueError, match=r"2 frame.*at least 3"):
        behaviours.label(runs(grid()[:2]))


def test_no_worlds_have_no_labels() -> None:
    assert behaviours.label(runs(grid())[:0]) == []


def test_one_robot_or_a_thousand_are_measured_without_a_warning() -> None:
    alone = load_world("hero_plus", num_robots=1)
    assert behaviours.label(runs(grid()[:, :1], alone))[0] in behaviours.LABELS
    many = HERO.with_robots(1000, scale_arena=True)
    paths = np.random.default_rng(0).uniform(0.1, 10, (1, 1000, 2)) + np.zeros((50, 1, 1))
    assert behaviours.label(runs(paths, many)) == ["random"]

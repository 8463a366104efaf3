"""The paper's greyscale videos against a brute-force drawing, and what they may not depend on."""

from __future__ import annotations

import dataclasses
import math
from types import SimpleNamespace

import numpy as np
import numpy.typing as npt
import pytest

from swarm_envs import Trajectories, load_world
from swarm_envs.rendering import frame_indices, videos
from swarm_envs.rendering.greyscale import (
    BODY_GREY,
    HEADINGS,
    MARK_GREY,
    MARK_LENGTH,
    MARK_WIDTH,
    OBJECT_GREY,
    OBSTACLE_GREY,
    OUTLINE_WIDTH,
)
from swarm_envs.worlds import Obstacle, PushableObject, WorldSpec

HERO = load_world("hero_plus")
WIDTH, HEIGHT = 1.70, 1.42


def runs(poses: npt.ArrayLike, world: WorldSpec = HERO) -> Trajectories:
    array = np.asarray(poses, dtype=np.float64)
    shape = array.shape[:3]
    time = 0.1 * np.arange(shape[1])
    return Trajectories(world, "constructed", time, array, np.zeros(shape, np.uint8), np.zeros((*shape, 2)))


def one_frame(poses: npt.ArrayLike, world: WorldSpec = HERO, size: int = 64) -> npt.NDArray[np.float64]:
    """The picture of one moment (robots, 3)."""
    return videos(runs(np.asarray(poses)[None, None], world), frames=1, size=size)[0, 0].astype(np.float64)


def brute_force(poses: npt.NDArray[np.float64], size: int, fine: int = 16) -> npt.NDArray[np.float64]:
    """Draw every point of a much finer grid, then average: an independent reading of the documented picture."""
    at = (np.arange(size * fine) + 0.5) / (size * fine)
    x, y = at[None, :] * WIDTH, (1 - at[:, None]) * HEIGHT
    total = np.zeros((size * fine, size * fine))
    for px, py, heading in poses:
        distance = np.hypot(x - px, y - py)
        along = (x - px) * math.cos(heading) + (y - py) * math.sin(heading)
        across = (y - py) * math.cos(heading) - (x - px) * math.sin(heading)
        grey = np.where(distance <= 0.04, BODY_GREY, 0)
        grey = np.where((distance <= 0.06) & (distance >= 0.06 - OUTLINE_WIDTH), MARK_GREY, grey)
        grey = np.where((along >= 0) & (along <= MARK_LENGTH * 0.04) & (np.abs(across) <= MARK_WIDTH / 2), MARK_GREY, grey)
        total += grey
    return np.minimum(total, 255).reshape(size, fine, size, fine).mean(axis=(1, 3))


def scattered(count: int = 8, seed: int = 0) -> npt.NDArray[np.float64]:
    """Poses that do not overlap, at headings that are drawn exactly."""
    rng = np.random.default_rng(seed)
    places = np.array([(x, y) for x in (0.2, 0.55, 0.9, 1.25, 1.55) for y in (0.2, 0.6, 1.0, 1.3)])
    chosen = rng.permutation(places)[:count] + rng.uniform(-0.05, 0.05, (count, 2))
    return np.concatenate([chosen, 2 * np.pi / HEADINGS * rng.integers(0, HEADINGS, (count, 1))], axis=1)


@pytest.mark.parametrize("size", [64, 100])
def test_a_picture_equals_a_brute_force_drawing_within_the_rounding_to_an_eighth_of_a_pixel(size: int) -> None:
    for seed in range(3):
        poses = scattered(seed=seed)
        drawn, expected = one_frame(poses, size=size), brute_force(poses, size)
        assert np.abs(drawn - expected).max() < 35  # an edge moved by 1/16 pixel, along both axes
        assert np.abs(drawn - expected).sum() < 0.06 * expected.sum()
        assert drawn.sum() == pytest.approx(expected.sum(), rel=0.01)


def test_light_falls_where_robots_are_and_up_is_up() -> None:
    poses = np.tile([0.3, 1.2, 0.0], (8, 1))
    picture = one_frame(poses)
    row, column = np.average(np.indices(picture.shape).reshape(2, -1), axis=1, weights=picture.ravel())
    assert column == pytest.approx(0.3 / WIDTH * 64 - 0.5, abs=0.5)
    assert row == pytest.approx((1 - 1.2 / HEIGHT) * 64 - 0.5, abs=0.3)


def test_the_heading_shows() -> None:
    def centre(heading: float) -> npt.NDArray[np.float64]:
        picture = one_frame(np.concatenate([[[0.85, 0.71, heading]], np.full((7, 3), np.nan)]))
        return np.average(np.indices(picture.shape).reshape(2, -1), axis=1, weights=picture.ravel())

    for heading in np.linspace(0, 2 * np.pi, 8, endpoint=False):
        row, column = centre(heading) - (centre(heading) + centre(heading + np.pi)) / 2
        assert math.atan2(-row * HEIGHT, column * WIDTH) == pytest.approx(math.remainder(heading, 2 * np.pi), abs=0.15)


def test_frames_are_the_ends_of_equal_parts_of_the_last_half() -> None:
    np.testing.assert_array_equal(frame_indices(601), [400, 500, 600])
    np.testing.assert_array_equal(frame_indices(121), [80, 100, 120])
    np.testing.assert_array_equal(frame_indices(601, 1), [600])
    np.testing.assert_array_equal(frame_indices(601, 6), [350, 400, 450, 500, 550, 600])
    np.testing.assert_array_equal(frame_indices(1), [0, 0, 0])
    poses = np.tile(np.array([5.0, 5.0, 0.0]), (1, 601, 8, 1))
    poses[0, [400, 500, 600], [0, 1, 2]] = [[0.3, 0.3, 0], [0.9, 0.9, 0], [1.4, 0.4, 0]]
    video = videos(runs(poses))
    assert video.shape == (1, 3, 64, 64)
    assert video.dtype == np.uint8
    np.testing.assert_array_equal(video[0, 1], one_frame(poses[0, 500]))
    assert (video.max(axis=(2, 3)) > 150).all()


def test_threads_batches_and_the_order_of_robots_change_nothing() -> None:
    rng = np.random.default_rng(1)
    trajectories = runs(rng.uniform([0, 0, -9], [WIDTH, HEIGHT, 9], (600, 4, 8, 3)))
    one = videos(trajectories, threads=1)
    np.testing.assert_array_equal(one, videos(trajectories, threads=4))
    np.testing.assert_array_equal(one[300:310], videos(trajectories[300:310]))
    np.testing.assert_array_equal(one, videos(runs(trajectories.poses[:, :, ::-1])))


def test_robots_outside_the_picture_or_without_a_pose_leave_it_whole() -> None:
    poses = scattered()
    poses[0] = [np.nan, 0.5, 0]
    poses[1] = [0.5, np.inf, 0]
    poses[2] = [-3, 0.5, 0]
    poses[3] = [1e300, -1e300, 1e300]
    poses[4] = [0.0, 0.0, 0.0]
    picture = one_frame(poses)
    assert picture[:8].max() > 0 or picture[-4:, :4].max() > 0
    np.testing.assert_array_equal(picture, one_frame(poses[[5, 6, 7, 4, 0, 0, 0, 0]]))


def test_an_empty_batch_gives_no_videos() -> None:
    assert videos(runs(np.zeros((0, 10, 8, 3)))).shape == (0, 3, 64, 64)


def test_obstacles_and_the_outside_of_a_concave_arena_away_from_the_origin_are_grey() -> None:
    outline = ((2.0, 1.0), (6.0, 1.0), (6.0, 5.0), (4.0, 5.0), (4.0, 3.0), (2.0, 3.0))
    arena = dataclasses.replace(HERO.arena, outline=outline, obstacles=(Obstacle(((4.5, 1.5), (5.5, 1.5), (5.5, 2.5), (4.5, 2.5))),))
    picture = one_frame(np.full((8, 3), np.nan), HERO.replace(arena=arena))
    assert (picture[:31, :31] == OBSTACLE_GREY).all()
    assert (picture[33:, :39] == 0).all()
    assert picture[48, 48] == OBSTACLE_GREY
    assert picture.mean() == pytest.approx(OBSTACLE_GREY * (0.25 + 1 / 16), rel=0.03)


def test_pushable_objects_are_drawn_where_they_are() -> None:
    items = (PushableObject("box", (0.4, 0.2), (0.5, 0.5, 0.0)), PushableObject("disc", (0.1,), (1.2, 1.0, 0.0)))
    source = SimpleNamespace(
        poses=np.full((1, 2, 8, 3), np.nan),
        world=HERO.replace(objects=items),
        object_poses=np.array([[[[0.5, 0.5, np.pi / 2], [1.2, 1.0, 0.0]]] * 2]),
    )
    picture = videos(source, frames=1)[0, 0].astype(float)
    pixel = WIDTH * HEIGHT / 64**2
    assert picture.sum() * pixel / OBJECT_GREY == pytest.approx(0.08 + math.pi * 0.01, rel=0.04)
    rows, columns = np.nonzero(picture[:, :32])
    assert np.ptp(rows) * HEIGHT > np.ptp(columns) * WIDTH  # the box stands upright


def test_a_thousand_robots_fit_in_a_picture() -> None:
    world = HERO.with_robots(1000, scale_arena=True)
    poses = np.random.default_rng(0).uniform(0, 1, (1, 3, 1000, 3)) * [*world.size, 7]
    assert videos(runs(poses, world)).mean() > 2


@pytest.mark.parametrize(
    ("given", "name"), [({"size": 4}, "size"), ({"size": 2.5}, "size"), ({"frames": 0}, "frames"), ({"frames": True}, "frames")]
)
def test_impossible_pictures_are_refused_by_name(given: dict[str, int], name: str) -> None:
    with pytest.raises(ValueError, match=f"^{name} is"):
        videos(runs(np.zeros((1, 4, 8, 3))), **given)

"""The robots' paths against a brute-force drawing, and how they lie under the videos."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from swarm_envs import Trajectories, load_world
from swarm_envs.rendering import frame_indices, trails, videos
from swarm_envs.rendering.trails import PATH_GREY

HERO = load_world("hero_plus")
WIDTH, HEIGHT = 1.70, 1.42
PIXEL = WIDTH / 64


def runs(poses: npt.ArrayLike) -> Trajectories:
    array = np.asarray(poses, dtype=np.float64)
    shape = array.shape[:3]
    return Trajectories(HERO, "constructed", 0.1 * np.arange(shape[1]), array, np.zeros(shape, np.uint8), np.zeros((*shape, 2)))


def wandering(worlds: int = 3, ticks: int = 61) -> npt.NDArray[np.float64]:
    """Eight robots that drive up to 2 cm per tick, turning now and then."""
    generator = np.random.default_rng(2)
    headings = np.cumsum(generator.normal(0, 0.3, (worlds, ticks, 8)), axis=1) + generator.uniform(-3, 3, (worlds, 1, 8))
    steps = np.stack([np.cos(headings), np.sin(headings)], axis=-1) * generator.uniform(0, 0.02, (worlds, 1, 8, 1))
    places = generator.uniform([0.3, 0.3], [1.4, 1.1], (worlds, 1, 8, 2)) + np.cumsum(steps, axis=1)
    return np.concatenate([places, headings[..., None]], axis=-1)


def brute_force(poses: npt.NDArray[np.float64], start: int, end: int, size: int, fine: int = 8) -> npt.NDArray[np.float64]:
    """Draw (ticks, robots, 3) on a much finer grid, tick by tick, keep the lightest and average."""
    at = (np.arange(size * fine) + 0.5) / (size * fine)
    x, y = at[None, :] * WIDTH, (1 - at[:, None]) * HEIGHT
    canvas = np.zeros((size * fine, size * fine))
    for tick in range(start + 1, end + 1):
        for px, py, _ in poses[tick]:
            inside = np.hypot(x - px, y - py) <= 0.02
            canvas[inside] = np.maximum(canvas[inside], 160 * (tick - start) / (end - start))
    return canvas.reshape(size, fine, size, fine).mean(axis=(1, 3))


def test_paths_equal_a_brute_force_drawing_but_for_the_softness_of_edges() -> None:
    poses = wandering(1)
    found = trails(runs(poses), frames=2)[0].astype(float)
    for k, (start, end) in enumerate([(30, 45), (45, 60)]):
        expected = brute_force(poses[0], start, end, 64)
        difference = np.abs(found[k] - expected)
        assert difference.mean() < 0.03 * expected[expected > 0].mean()
        assert difference.max() < 0.3 * PATH_GREY
        assert np.corrcoef(found[k].ravel(), expected.ravel())[0, 1] > 0.98


def test_a_picture_shows_the_time_since_the_picture_before_it() -> None:
    poses = np.full((1, 61, 8, 3), np.nan)
    where = [0.2, 0.4, 0.6, 0.8]
    for tick, x in zip((25, 35, 45, 55), where, strict=True):
        poses[0, tick, 0] = x, 0.71, 0.0
    found = trails(runs(poses), frames=3)[0]
    assert frame_indices(61, 3).tolist() == [40, 50, 60]
    columns = [int(x / PIXEL) for x in where]
    assert [[bool(picture[31:33, column].any()) for column in columns] for picture in found] == [
        [False, True, False, False], [False, False, True, False], [False, False, False, True],
    ]  # fmt: skip


def test_a_path_is_lightest_where_the_robot_is_and_fades_evenly_into_the_past() -> None:
    ticks = 201
    poses = np.full((1, ticks, 8, 3), np.nan)
    poses[0, :, 0] = np.stack([0.2 + 0.006 * np.arange(ticks), np.full(ticks, 0.5 * HEIGHT - HEIGHT / 128), np.zeros(ticks)], axis=1)
    line = trails(runs(poses), frames=1)[0, 0, 32].astype(float)
    first, last = int((poses[0, 101, 0, 0] - 0.01) / PIXEL), int(poses[0, -1, 0, 0] / PIXEL)
    assert np.all(line[: first - 1] == 0)
    assert np.all(np.diff(line[first + 1 : last]) > 0)
    assert 0.9 * PATH_GREY < line.max() <= PATH_GREY
    middle = line[(first + last) // 2]
    assert abs(middle - PATH_GREY / 2) < 0.12 * PATH_GREY


def test_robots_that_stand_still_leave_no_trail_beyond_themselves() -> None:
    poses = np.repeat(wandering(2)[:, -1:], 61, axis=1)
    filmed = videos(runs(poses))
    assert np.all(trails(runs(poses)).astype(int) <= filmed.astype(int) + 8), "but for rounding"


def test_trails_depend_neither_on_threads_nor_on_the_batch_and_have_the_videos_shape() -> None:
    poses = wandering(300, 21)
    one = trails(runs(poses), threads=1)
    np.testing.assert_array_equal(one, trails(runs(poses), threads=4))
    np.testing.assert_array_equal(one[255:258], trails(runs(poses[255:258])))
    assert one.shape == videos(runs(poses)).shape
    assert trails(runs(poses[:0]), frames=2, size=32).shape == (0, 2, 32, 32)


def test_robots_without_a_position_are_left_out() -> None:
    poses = wandering(1)
    poses[:, :, 3:] = np.nan
    poses[:, :, 2] = 1e300
    assert trails(runs(poses)).any()
    poses[:, :, :2] = np.inf
    assert not trails(runs(poses)).any()

"""The colour picture: size, geometry, anti-aliasing, and robustness."""

from __future__ import annotations

import dataclasses
import math
import subprocess
import sys

import numpy as np
import numpy.typing as npt
import pytest

from swarm_envs import load_world
from swarm_envs.rendering import Renderer, raster, render, view_of
from swarm_envs.rendering.palette import FLASH, OBJECT, OBSTACLE, WALL, robot_colours
from swarm_envs.worlds import Obstacle, PushableObject, Sensor, WorldSpec

HERO = load_world("hero_plus")
NOBODY = np.full((8, 3), np.nan)


def only(x: float, y: float, heading: float, robots: int = 8) -> npt.NDArray[np.float64]:
    """Poses of which only the first is drawn."""
    poses = np.full((robots, 3), np.nan)
    poses[0] = x, y, heading
    return poses


def changed(poses: npt.NDArray[np.float64], world: WorldSpec = HERO, **more: object) -> npt.NDArray[np.bool_]:
    """Which pixels differ from the empty arena."""
    return np.any(render(world, poses, **more) != render(world, NOBODY[: world.num_robots]), axis=-1)  # type: ignore[arg-type]


def test_the_papers_arena_is_513_by_426_at_three_pixels_a_centimetre() -> None:
    assert render(HERO, NOBODY).shape == (426, 513, 3)
    assert render(HERO, NOBODY).dtype == np.uint8
    assert view_of(HERO).scale == 300
    inner = tuple((x * 161 / 170, y * 132 / 142) for x, y in HERO.arena.outline)
    authors = HERO.replace(arena=dataclasses.replace(HERO.arena, outline=inner, picture_border=0.05))
    assert Renderer(authors).shape == (426, 513, 3)


@pytest.mark.parametrize("width", [1, 64, 171, 320, 800])
def test_other_widths_keep_the_arenas_shape_and_show_all_of_it(width: int) -> None:
    view = view_of(HERO, width)
    assert view.height == pytest.approx(width * 1.42 / 1.70, abs=1 + 0.01 * width)
    corners = view.pixels(np.array([[0, 0], [1.70, 1.42]]))
    assert (corners >= -0.51).all()
    assert (corners <= [view.width + 0.51, view.height + 0.51]).all()


def test_a_given_height_centres_the_arena() -> None:
    renderer = Renderer(HERO, 600, 600)
    assert renderer.shape == (600, 600, 3)
    np.testing.assert_allclose(renderer.view.pixels(np.array([0.85, 0.71])), [300, 300])


@pytest.mark.parametrize("side", [0, -3, 2.5, True])
def test_impossible_sides_are_refused(side: float) -> None:
    with pytest.raises(ValueError, match="width is"):
        Renderer(HERO, side)  # type: ignore[arg-type]


def test_coverage_of_a_disc_equals_supersampled_brute_force() -> None:
    canvas, white = np.zeros((40, 40, 3), np.uint8), np.full(3, 255, np.uint8)
    x, y, radius = 19.3, 20.8, 9.4
    raster.annulus(canvas, x, y, -1.0, radius, white, 1.0)
    fine = (np.arange(40 * 16) + 0.5) / 16
    inside = np.hypot(fine[None] - x, fine[:, None] - y) <= radius
    expected = 255 * inside.reshape(40, 16, 40, 16).mean(axis=(1, 3))
    assert np.abs(canvas[..., 0] - expected).max() < 24
    assert canvas[..., 0].sum() == pytest.approx(255 * math.pi * radius**2, rel=0.003)


@pytest.mark.parametrize("angle", [0.0, 0.5, 2.0, -1.2])
def test_a_box_and_a_beam_cover_their_areas_at_any_angle(angle: float) -> None:
    canvas, white = np.zeros((120, 120, 3), np.uint8), np.full(3, 255, np.uint8)
    raster.box(canvas, 60.0, 60.0, angle, 30.0, 10.0, 0.0, white, 1.0)
    assert canvas[..., 0].sum() / 255 == pytest.approx(1200, rel=0.01)
    for half in (0.12, 0.8, 1.6, 2.5, math.pi):
        canvas[:] = 0
        raster.sector(canvas, 60.0, 60.0, angle, half, 50.0, white, 1.0, 1.0)
        assert canvas[..., 0].sum() / 255 == pytest.approx(half * 50**2, rel=0.02)


def test_a_trail_is_even_where_its_pieces_meet() -> None:
    canvas, white = np.zeros((60, 100, 3), np.uint8), np.full(3, 255, np.uint8)
    for k in range(10):
        raster.stroke(canvas, 5.0 + 9 * k, 10.0 + 4 * k, 14.0 + 9 * k, 14.0 + 4 * k, 3.0, white, 0.5)
    assert canvas.max() <= 128
    assert canvas[..., 0].sum() / 127.5 == pytest.approx(3 * 10 * math.hypot(9, 4), rel=0.03)


def test_a_robot_is_drawn_as_large_as_it_is_where_it_is() -> None:
    rows, columns = np.nonzero(changed(only(0.5, 1.0, 0.3)))
    assert (columns.min() + columns.max() + 1) / 2 == pytest.approx(1.5 + 300 * 0.5, abs=1)
    assert (rows.min() + rows.max() + 1) / 2 == pytest.approx(426 - 300 * 1.0, abs=1)
    assert columns.max() - columns.min() == pytest.approx(36, abs=2)


def test_each_robot_keeps_its_colour_and_the_first_eight_differ() -> None:
    colours = robot_colours(20)
    assert len(np.unique(colours[:8], axis=0)) == 8
    np.testing.assert_array_equal(colours[:8], colours[8:16])
    poses = np.stack([np.linspace(0.1, 1.6, 8), np.full(8, 0.7), np.full(8, np.pi / 2)], axis=1)
    picture = render(HERO, poses)
    for index, (column, row) in enumerate(view_of(HERO).pixels(poses).astype(int)):
        np.testing.assert_array_equal(picture[row + 6, column], colours[index])  # behind the centre, clear of the mark


def test_the_mark_points_along_the_heading_counter_clockwise_and_up() -> None:
    picture = render(HERO, only(0.85, 0.7, np.pi / 2)).astype(int)
    column, row = view_of(HERO).pixels(np.array([0.85, 0.7])).astype(int)
    assert picture[row - 15, column].sum() < 150 < picture[row + 15, column].sum()


def test_the_beam_reaches_as_far_as_the_sensor_and_shines_when_it_sees() -> None:
    blind = changed(only(0.2, 0.7, 0.0), detections=np.zeros(8))
    assert np.nonzero(blind)[1].max() == pytest.approx(1.5 + 300 * 1.2, abs=2)
    seen, idle = (render(HERO, only(0.2, 0.7, 0.0), detections=np.full(8, value)).astype(int) for value in (1, 0))
    empty = render(HERO, NOBODY).astype(int)
    assert np.abs(seen - empty).sum() > 2 * np.abs(idle - empty).sum()


def test_a_second_sensor_has_its_own_beam() -> None:
    behind = Sensor(half_angle=0.12, range=0.5, bearing=math.pi)
    world = HERO.replace(robots=tuple(dataclasses.replace(r, sensors=(*r.sensors, behind)) for r in HERO.robots))
    detections = np.zeros((8, 2))
    columns = np.nonzero(changed(only(0.85, 0.7, 0.0), world, detections=detections))[1]
    assert columns.min() == pytest.approx(1.5 + 300 * 0.35, abs=2)
    with pytest.raises(ValueError, match="detections have shape"):
        render(world, NOBODY, detections=np.zeros(8))


def test_contact_flashes() -> None:
    picture = render(HERO, only(0.5, 0.5, 0.0), contacts=np.ones(8, bool))
    assert np.any(np.abs(picture.astype(int) - FLASH).max(axis=-1) < 20)
    assert not np.any(np.abs(render(HERO, only(0.5, 0.5, 0.0)).astype(int) - FLASH).max(axis=-1) < 20)


def test_a_trail_fades_towards_its_old_end() -> None:
    path = np.full((50, 8, 2), np.nan)
    path[:, 0] = np.stack([np.linspace(0.2, 1.5, 50), np.full(50, 0.7)], axis=1)
    drawn = render(HERO, NOBODY, trail=path).astype(int)
    strength = np.abs(drawn - render(HERO, NOBODY).astype(int)).sum(axis=(0, 2))
    assert strength[450] > 2 * strength[150] > 0


def test_a_concave_arena_away_from_the_origin_with_obstacles_and_objects_is_drawn() -> None:
    outline = ((-6.0, 1.0), (-2.0, 1.0), (-2.0, 5.0), (-4.0, 5.0), (-4.0, 3.0), (-6.0, 3.0))
    arena = dataclasses.replace(HERO.arena, outline=outline, obstacles=(Obstacle(((-3.5, 1.5), (-2.5, 1.5), (-2.5, 2.5), (-3.5, 2.5))),))
    items = (PushableObject("box", (0.5, 0.3), (-5.0, 2.0, 0.4)), PushableObject("disc", (0.2,), (-3.0, 4.0, 0.0)))
    world = HERO.replace(arena=arena, objects=items)
    view, picture = view_of(world), render(world, only(-5.5, 1.5, 0.0))

    def at(x: float, y: float) -> npt.NDArray[np.uint8]:
        column, row = view.pixels(np.array([x, y])).astype(int)
        return picture[row, column]

    np.testing.assert_array_equal(at(-5, 4), WALL)
    np.testing.assert_array_equal(at(-3, 2), OBSTACLE)
    np.testing.assert_array_equal(at(-5, 2), OBJECT)
    np.testing.assert_array_equal(at(-3, 4), OBJECT)
    moved = render(world, NOBODY, object_poses=[[-5, 2, 0.4], [-3.0, 3.2, 0.0]])
    column, row = view.pixels(np.array([-3.0, 3.2])).astype(int)
    np.testing.assert_array_equal(moved[row, column], OBJECT)


def test_robots_outside_the_picture_are_left_out_without_harm() -> None:
    poses = np.array(
        [[-9, 0.5, 0], [1e200, 0, 0], [np.inf, 1, 0], [0.5, np.nan, 0], [0.5, 0.5, np.inf], [9, 9, 1], [-1e7, 0, 0], [0.5, 99, 0]]
    )
    trail = np.random.default_rng(0).uniform(-1e9, 1e9, (20, 8, 3))
    picture = render(HERO, poses, detections=np.ones(8), trail=trail, contacts=np.ones(8))
    assert picture.shape == (426, 513, 3)


def test_a_thousand_robots_are_drawn() -> None:
    world = HERO.with_robots(1000, scale_arena=True)
    poses = np.random.default_rng(0).uniform(0, 1, (1000, 3)) * [*world.size, 7]
    picture = render(world, poses, detections=np.zeros(1000), contacts=np.zeros(1000))
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 100


def test_pictures_are_new_arrays_and_the_arguments_stay_as_they_were() -> None:
    renderer, poses = Renderer(HERO), only(0.5, 0.5, 0.0)
    before = poses.copy()
    first = renderer(poses)
    first[:] = 0
    assert renderer(poses).mean() > 200
    np.testing.assert_array_equal(poses, before)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"poses": np.zeros((3, 3))}, r"poses have shape \(3, 3\), expected \(8, 3\)"),
        ({"trail": np.zeros((5, 3, 2))}, r"trail has shape \(5, 3, 2\), expected \(points, 8, 2 or 3\)"),
        ({"detections": np.zeros(3)}, r"detections have shape \(3,\), expected \(8,\)"),
        ({"contacts": np.zeros(3)}, r"contacts have shape \(3,\), expected \(8,\)"),
    ],
)
def test_arrays_of_another_shape_are_refused_with_both_shapes(given: dict[str, npt.NDArray[np.float64]], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Renderer(HERO)(**{"poses": NOBODY, **given})


def test_importing_rendering_imports_no_plotting_or_video_library() -> None:
    heavy = ("matplotlib", "imageio", "imageio_ffmpeg", "av", "cv2", "pygame")
    code = f"import sys, swarm_envs.rendering; print([name for name in {heavy} if name in sys.modules])"
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.strip() == "[]"

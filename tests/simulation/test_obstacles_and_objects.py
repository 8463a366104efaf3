"""Arenas of any outline, obstacles, pushable discs and boxes, and sensors that cannot look through them."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
import shapely
import shapely.affinity

from swarm_envs import Simulation, Trajectories, WorldError, load_world, rollouts
from swarm_envs.worlds import Arena, Obstacle, PushableObject, Sensor, WorldSpec

OUTLINES = {
    "L": ((0.0, 0.0), (2.0, 0.0), (2.0, 0.8), (0.8, 0.8), (0.8, 2.0), (0.0, 2.0)),
    "star": tuple((1.5 + r * np.cos(a), 1.5 + r * np.sin(a)) for a, r in zip(np.arange(10) * np.pi / 5, [1.5, 0.8] * 5, strict=True)),
    "round": tuple((1.0 + np.cos(a), 1.0 + np.sin(a)) for a in np.arange(200) * np.pi / 100),
    "clockwise": ((0.0, 0.0), (0.0, 1.42), (1.7, 1.42), (1.7, 0.0)),
}
THIN_WALL = Obstacle(((0.6, 0.3), (0.61, 0.3), (0.61, 0.5), (0.6, 0.5)))


def inside(world: WorldSpec, margin: float) -> shapely.Geometry:
    floor = shapely.Polygon(world.arena.outline).buffer(-margin, quad_segs=64)
    for obstacle in world.arena.obstacles:
        floor = floor.difference(shapely.Polygon(obstacle.outline).buffer(margin, quad_segs=64))
    return floor


@pytest.mark.parametrize("engine", ["chipmunk", "disc"])
@pytest.mark.parametrize("name", OUTLINES)
def test_nobody_leaves_an_arena_of_any_outline_or_enters_an_obstacle(name: str, engine: str) -> None:
    world = load_world("hero_plus")
    obstacles = (THIN_WALL,) if name == "L" else ()
    world = dataclasses.replace(world, arena=Arena(OUTLINES[name], obstacles))
    controllers = np.random.default_rng(1).uniform(-1, 1, (30, 4)) * [0.09, 1.6, 0.09, 1.6]
    controllers[:5] = [0.09, 0.0, 0.09, 0.0]
    poses = rollouts(world, controllers, seed=3, engine=engine, steps=400, record_every=4).poses
    slack = {"chipmunk": 5e-3, "disc": 1e-3}[engine]
    allowed = inside(world, 0.06 - slack)
    shapely.prepare(allowed)
    assert shapely.intersects_xy(allowed, poses[..., 0], poses[..., 1]).all()


def pushing(item: PushableObject, seconds: float = 10.0) -> np.ndarray:
    """Path of an object (frames, 6) that a robot at 0.09 m/s drives into."""
    world = dataclasses.replace(load_world("hero_plus", num_robots=1), objects=(item,))
    simulation = Simulation(world, 1)
    simulation.reset(0, initial_poses=np.array([[[0.3, 0.7, 0.0]]]))
    path = [simulation.state.objects[0, 0].copy()]
    for _ in range(round(seconds / 0.1)):
        simulation.step([[[0.09, 0.0]]])
        path.append(simulation.state.objects[0, 0].copy())
    return np.array(path)


@pytest.mark.parametrize("shape", [("disc", (0.05,)), ("box", (0.1, 0.1))])
def test_a_light_object_is_pushed_and_a_heavy_one_stays(shape: tuple[str, tuple[float, ...]]) -> None:
    light = pushing(PushableObject(*shape, pose=(0.6, 0.7, 0.0), mass=0.02, floor_friction=0.2))
    heavy = pushing(PushableObject(*shape, pose=(0.6, 0.7, 0.0), mass=5.0, floor_friction=1.0))
    assert light[-1, 0] - light[0, 0] > 0.4
    assert np.abs(heavy[:, :3] - heavy[0, :3]).max() < 2e-3


def test_rollouts_record_where_objects_go_and_the_file_keeps_it(tmp_path: Path) -> None:
    item = PushableObject("box", (0.1, 0.1), pose=(0.6, 0.7, 0.0), mass=0.02, floor_friction=0.2)
    world = dataclasses.replace(load_world("hero_plus", num_robots=1), objects=(item,))
    start = np.array([[[0.3, 0.7, 0.0]]])
    runs = rollouts(world, [[0.09, 0.0, 0.09, 0.0]], initial_poses=start, steps=100, record_every=7)
    simulation = Simulation(world, 1)
    simulation.reset(0, initial_poses=start)
    assert runs.object_poses.shape == (1, 15, 1, 3)
    for tick in range(99):
        if tick % 7 == 0:
            assert (runs.object_poses[0, tick // 7] == simulation.objects[0]).all()
            assert (runs.poses[0, tick // 7] == simulation.poses[0]).all()
        simulation.step([[[0.09, 0.0]]])
    assert runs.object_poses[0, -1, 0, 0] > 0.75, "pushed"
    again = Trajectories.load(runs.save(tmp_path / "pushed"))
    assert (again.object_poses == runs.object_poses).all()
    assert (again[:1].object_poses == runs.object_poses).all()
    assert rollouts(world, [[0.0, 0.0, 0.0, 0.0]], steps=0).object_poses.shape == (1, 1, 1, 3)
    assert rollouts("hero_plus", [[0.0, 0.0, 0.0, 0.0]], steps=1).object_poses is None


def test_a_sliding_object_is_stopped_by_the_floors_friction_within_coulombs_distance() -> None:
    world = dataclasses.replace(
        load_world("hero_plus", num_robots=1), objects=(PushableObject("disc", (0.05,), (0.6, 0.7, 0.0), mass=0.05, floor_friction=0.01),)
    )
    simulation = Simulation(world, 1)
    simulation.reset(0, initial_poses=np.array([[[0.3, 0.2, 0.0]]]))
    simulation.state.objects[0, 0, 3] = 0.3
    for _ in range(60):
        simulation.step([[[0.0, 0.0]]])
    assert simulation.objects[0, 0, 0] - 0.6 == pytest.approx(0.3**2 / (2 * 0.01 * 9.81), rel=0.05)
    assert simulation.state.objects[0, 0, 3:].tolist() == pytest.approx([0.0, 0.0, 0.0], abs=1e-9)


def test_the_disc_engine_refuses_objects_with_a_reason() -> None:
    world = dataclasses.replace(load_world("hero_plus"), objects=(PushableObject("disc", (0.05,), (0.2, 0.2, 0.0)),))
    with pytest.raises(WorldError, match="engine 'disc' cannot push objects, the world has 1; use engine='chipmunk'"):
        Simulation(world, 1, "disc")


@pytest.mark.parametrize("hidden_by", ["obstacle", "disc", "box", "nothing", "glass"])
def test_a_sensor_that_minds_occlusion_does_not_look_through_opaque_things(hidden_by: str) -> None:
    world = load_world("hero_plus", num_robots=2)
    robots = tuple(dataclasses.replace(r, sensors=(Sensor(0.12, 1.0, occlusion=True),)) for r in world.robots)
    wall = ((0.8, 0.5), (0.82, 0.5), (0.82, 0.9), (0.8, 0.9))
    obstacles = {"obstacle": (Obstacle(wall),), "glass": (Obstacle(wall, opaque=False),)}.get(hidden_by, ())
    things = {"disc": PushableObject("disc", (0.1,), (0.8, 0.7, 0.0)), "box": PushableObject("box", (0.05, 0.3), (0.8, 0.7, 0.0))}
    objects = (things[hidden_by],) if hidden_by in things else ()
    world = dataclasses.replace(world, robots=robots, objects=objects, arena=dataclasses.replace(world.arena, obstacles=obstacles))
    simulation = Simulation(world, 1)
    simulation.reset(0, initial_poses=np.array([[[0.5, 0.7, 0.0], [1.1, 0.7, 0.0]]]))
    assert simulation.detections[0, 0] == (hidden_by in ("nothing", "glass"))


def sector(pose: np.ndarray, half_angle: float, reach: float) -> shapely.Polygon:
    angles = pose[2] + np.linspace(-half_angle, half_angle, 721)
    rim = pose[:2] + reach * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return shapely.make_valid(shapely.Polygon([pose[:2], *rim]))


@pytest.mark.parametrize("half_angle", [0.05, 0.12, 0.8, 2.4, np.pi])
def test_a_box_is_seen_exactly_when_its_outline_meets_the_sector(half_angle: float) -> None:
    item = PushableObject("box", (0.3, 0.1), (0.85, 0.7, 0.0))
    world = load_world("hero_plus", num_robots=1)
    robots = tuple(dataclasses.replace(robot, sensors=(Sensor(half_angle, 0.5, sees_objects=True),)) for robot in world.robots)
    generator = np.random.default_rng(3)
    count = 2000
    simulation = Simulation(dataclasses.replace(world, robots=robots, objects=(item,)), count)
    simulation.poses[:, 0] = [0.85, 0.7, 0.0]
    simulation.poses[:, 0, 2] = generator.uniform(-7, 7, count)
    distance, bearing = generator.uniform(0.0, 0.6, count), generator.uniform(-np.pi, np.pi, count)
    boxes = simulation.state.objects[:, 0]
    boxes[:, 0], boxes[:, 1] = 0.85 + distance * np.cos(bearing), 0.7 + distance * np.sin(bearing)
    boxes[:, 2] = generator.uniform(-7, 7, count)
    simulation.observe()
    tried = 0
    for k in range(count):
        turned = shapely.affinity.rotate(shapely.box(-0.15, -0.05, 0.15, 0.05), boxes[k, 2], use_radians=True)
        outline = shapely.affinity.translate(turned, *boxes[k, :2])
        view = sector(simulation.poses[k, 0], half_angle, 2.0)
        expected = {bool(view.intersects(outline.buffer(margin))) and distance[k] <= 0.5 for margin in (-1e-3, 1e-3)}
        if len(expected) == 1:  # not on the sector's edge
            tried += 1
            assert simulation.detections[k, 0] == expected.pop(), k
    assert tried > 0.9 * count
    assert 0.02 < simulation.detections.mean() < 0.95


def test_a_box_half_hidden_is_seen_and_one_wholly_hidden_is_not() -> None:
    world = load_world("hero_plus", num_robots=1)
    robots = tuple(dataclasses.replace(r, sensors=(Sensor(0.3, 1.0, occlusion=True, sees_objects=True),)) for r in world.robots)
    seen = []
    for top in (0.7, 1.0):
        wall = ((0.8, 0.3), (0.82, 0.3), (0.82, top), (0.8, top))
        arena = dataclasses.replace(world.arena, obstacles=(Obstacle(wall),))
        objects = (PushableObject("box", (0.1, 0.4), (1.1, 0.7, 0.0)),)
        simulation = Simulation(dataclasses.replace(world, robots=robots, objects=objects, arena=arena), 1)
        simulation.reset(0, initial_poses=np.array([[[0.5, 0.7, 0.0]]]))
        seen.append(bool(simulation.detections[0, 0]))
    assert seen == [True, False]


@pytest.mark.parametrize("engine", ["chipmunk", "disc"])
def test_any_recorded_frame_is_a_start(engine: str) -> None:
    controllers = [[-0.09, -1.2, 0.0, -1.6], [0.09, 0.0, 0.09, 0.0]] * 4
    frames = rollouts("hero_plus", controllers, steps=300, record_every=60, engine=engine).poses
    for frame in range(frames.shape[1]):
        again = rollouts("hero_plus", controllers, initial_poses=frames[:, frame], steps=0, engine=engine)
        assert (again.poses[:, 0] == frames[:, frame]).all()


@pytest.mark.parametrize("engine", ["chipmunk", "disc"])
def test_commands_of_another_shape_or_not_finite_are_refused(engine: str) -> None:
    simulation = Simulation("hero_plus", 1, engine)
    before = simulation.poses.copy()
    for wrong in (np.zeros((2, 8, 2)), np.zeros((1, 3, 2)), np.full((1, 8, 2), np.nan)):
        with pytest.raises(WorldError, match=r"commands: given .* expected \(1, 8, 2\) finite speeds"):
            simulation.step(wrong)
    with pytest.raises(WorldError, match="which names world 9, expected indices from 0 to 0"):
        simulation.reset(which=np.array([9]))
    assert (simulation.poses == before).all()


@pytest.mark.parametrize("engine", ["chipmunk", "disc"])
def test_robots_that_were_put_elsewhere_go_on_from_there(engine: str) -> None:
    simulation = Simulation(load_world("hero_plus", num_robots=1), 1, engine)
    simulation.poses[0, 0] = [0.3, 0.3, 0.0]
    simulation.observe()
    simulation.step([[[0.09, 0.0]]])
    assert simulation.poses[0, 0].tolist() == pytest.approx([0.309, 0.3, 0.0])


def test_no_contact_is_dropped_when_many_fast_robots_crowd() -> None:
    world = dataclasses.replace(load_world("hero_plus_unlimited", num_robots=120), tick=0.5)
    poses = rollouts(world, [[0.2, 0.5, 0.2, -0.5]] * 2, steps=60, engine="disc").poses
    assert poses[..., 0].min() > 0.059
    assert poses[..., 1].max() < world.size[1] - 0.059


def test_a_deadband_that_stops_one_wheel_breaks_no_bound() -> None:
    world = load_world("hero_plus").with_effects(deadband=0.06)
    world = dataclasses.replace(world, limits=dataclasses.replace(world.limits, linear_speed=0.02, angular_speed=3.0))
    controllers = np.random.default_rng(0).uniform(-1, 1, (60, 4)) * [0.02, 3.0, 0.02, 3.0]
    at = rollouts(world, controllers, engine="disc").poses[..., :2]
    gaps = np.linalg.norm(at[:, :, :, None] - at[:, :, None], axis=-1) + np.eye(8)
    assert gaps.min() > 0.119


def test_a_corner_given_twice_is_refused() -> None:
    world = load_world("hero_plus")
    closed = dataclasses.replace(world, arena=Arena((*world.arena.outline, world.arena.outline[0])))
    with pytest.raises(WorldError, match="repeats the one before; list each corner once"):
        load_world(closed)

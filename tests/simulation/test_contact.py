"""The contact law: no overlap, nobody outside, Coulomb friction with spin, and both engines telling the same story."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_envs import Simulation, load_world, rollouts, world_names
from swarm_envs.worlds import Contact, WorldSpec

ENGINES = ["chipmunk", "disc"]
OVERLAP = {"chipmunk": 5e-3, "disc": 1e-3}
"""Greatest overlap in m that each engine promises."""
RADIUS = 0.06


def world_of(robots: int, robot_friction: float, wall_friction: float) -> WorldSpec:
    return dataclasses.replace(load_world("hero_plus", num_robots=robots), contact=Contact(robot_friction, wall_friction))


def run(world: WorldSpec, engine: str, poses: npt.ArrayLike, commands: npt.ArrayLike, ticks: int) -> npt.NDArray[np.float64]:
    simulation = Simulation(world, 1, engine)
    simulation.reset(0, initial_poses=np.array(poses, dtype=np.float64)[None])
    frames = [simulation.poses[0].copy()]
    for _ in range(ticks):
        simulation.step(np.array(commands, dtype=np.float64)[None])
        frames.append(simulation.poses[0].copy())
    return np.array(frames)


def deepest(poses: npt.NDArray[np.float64], size: tuple[float, float], radius: float = RADIUS) -> float:
    """Greatest overlap in m of two robots, or of a robot with a wall, in any frame (..., R, 3)."""
    at = poses[..., :2]
    gaps = np.linalg.norm(at[..., :, None, :] - at[..., None, :, :], axis=-1) - 2 * radius
    gaps[..., np.arange(at.shape[-2]), np.arange(at.shape[-2])] = np.inf
    walls = min((at - radius).min(), (np.array(size) - radius - at).min())
    return -min(float(gaps.min()), float(walls))


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("world", world_names())
def test_robots_of_random_controllers_never_overlap_or_leave(engine: str, world: str) -> None:
    spec = load_world(world)
    limits = [spec.limits.linear_speed, spec.limits.angular_speed] * 2
    controllers = np.random.default_rng(11).uniform(-1, 1, (100, 4)) * limits
    trajectories = rollouts(spec, controllers, seed=2, engine=engine)
    assert np.isfinite(trajectories.poses).all()
    assert deepest(trajectories.poses, spec.size, spec.robots[0].body.contact_radius) < OVERLAP[engine]


@settings(max_examples=25, deadline=None)
@given(
    seed=st.integers(0, 2**32),
    robots=st.integers(1, 30),
    engine=st.sampled_from(ENGINES),
    robot_friction=st.sampled_from([0.0, 0.3, 1.0, 3.0]),
    wall_friction=st.sampled_from([0.0, 0.4, 2.0]),
    eager=st.booleans(),
)
def test_no_action_breaks_the_bounds(seed: int, robots: int, engine: str, robot_friction: float, wall_friction: float, eager: bool) -> None:
    world = world_of(robots, robot_friction, wall_friction)
    simulation = Simulation(world, 1, engine)
    simulation.reset(seed)
    generator = np.random.default_rng(seed)
    commands = generator.uniform(-1, 1, (1, robots, 2)) * [0.09, 1.6]
    for _ in range(60):
        if not eager:
            commands = generator.uniform(-1, 1, (1, robots, 2)) * [0.09, 1.6]
        # eager robots all drive ahead for ever: piles against each other and the walls
        simulation.step(np.abs(commands) * [1, 0] if eager else commands)
        assert np.isfinite(simulation.poses).all()
        assert deepest(simulation.poses[0], world.size) < OVERLAP[engine]


@pytest.mark.parametrize("engine", ENGINES)
def test_equal_robots_head_on_stop_each_other(engine: str) -> None:
    frames = run(world_of(2, 0.0, 0.0), engine, [[0.6, 0.7, 0.0], [0.8, 0.7, np.pi]], [[0.09, 0.0], [0.09, 0.0]], 60)
    assert frames[-1, :, 0] == pytest.approx([0.64, 0.76], abs=3e-3)
    assert frames[-1, :, 1] == pytest.approx([0.7, 0.7], abs=1e-3)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_faster_robot_pushes_a_slower_one_at_their_mean_speed(engine: str) -> None:
    frames = run(world_of(2, 0.0, 0.0), engine, [[0.4, 0.7, 0.0], [0.52, 0.7, 0.0]], [[0.09, 0.0], [0.03, 0.0]], 50)
    assert np.diff(frames[10:, :, 0], axis=0) == pytest.approx(0.006, abs=2e-4)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_frictionless_robot_slides_along_a_wall_with_its_tangential_speed_and_keeps_its_heading(engine: str) -> None:
    heading = -np.pi / 3
    frames = run(world_of(1, 0.0, 0.0), engine, [[0.3, 0.06, heading]], [[0.09, 0.0]], 100)
    assert frames[-1, 0, 0] - 0.3 == pytest.approx(0.9 * np.cos(heading), abs=2e-3)
    assert frames[:, 0, 1] == pytest.approx(0.06, abs=2e-3)
    assert frames[-1, 0, 2] == pytest.approx(heading, abs=1e-9)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("mu", [0.1, 0.2])
def test_scraping_a_wall_slows_and_turns_as_coulombs_law_says(engine: str, mu: float) -> None:
    """Euler steps of 1 ms of v_t' = v cos a - mu v sin a, omega = -mu v sin a m r / I, while the contact point slides."""
    v, angle, ticks = 0.09, 0.5, 15
    x, heading = 0.3, -angle
    for _ in range(ticks * 100):
        into = max(0.0, -v * np.sin(heading))
        # m r^2 / I = 2 for a uniform disc; the wall's friction acts at r below the centre
        x += (v * np.cos(heading) - mu * into) * 1e-3
        heading -= mu * into * 2 / RADIUS * 1e-3
    frames = run(world_of(1, 0.3, mu), engine, [[0.3, RADIUS, -angle]], [[v, 0.0]], ticks)
    assert frames[-1, 0, 0] == pytest.approx(x, abs=3e-3)
    assert frames[-1, 0, 2] == pytest.approx(heading, abs=0.04)
    assert frames[-1, 0, 2] < -angle - 0.05, "friction must turn the nose into the wall"


@pytest.mark.parametrize("engine", ENGINES)
def test_above_the_critical_angle_a_robot_sticks_and_rolls_its_nose_into_the_wall(engine: str) -> None:
    # a desired velocity at angle a to the wall slides while tan a < 1 / (mu (1 + m r^2 / I)); beyond, the contact point stands still
    frames = run(world_of(1, 0.3, 1.0), engine, [[0.3, RADIUS, -1.2]], [[0.09, 0.0]], 200)
    x, heading = frames[:, 0, 0], frames[:, 0, 2]
    rolled = -(np.diff(heading)) * RADIUS
    assert np.diff(x)[1:] == pytest.approx(rolled[1:], abs=2e-4)
    assert heading[-1] == pytest.approx(-np.pi / 2, abs=0.02)
    assert np.abs(np.diff(x)[-20:]).max() < 1e-4


@pytest.mark.parametrize("engine", ENGINES)
def test_friction_between_robots_gears_their_turns(engine: str) -> None:
    # robot 0 spins in place, pressed against robot 1 that wants to stand: friction turns robot 1 the other way
    poses, commands = [[0.6, 0.7, 0.0], [0.72, 0.7, np.pi]], [[0.0, 1.0], [0.03, 0.0]]
    with_friction = run(world_of(2, 0.5, 0.0), engine, poses, commands, 20)
    without = run(world_of(2, 0.0, 0.0), engine, poses, commands, 20)
    assert with_friction[-1, 1, 2] < without[-1, 1, 2] - 0.02
    assert without[-1, 1, 2] == pytest.approx(np.pi, abs=1e-6)


@pytest.mark.parametrize("engine", ENGINES)
def test_contact_creates_no_energy(engine: str) -> None:
    """No robot moves faster than the fastest is asked to, and the swarm's kinetic energy never exceeds that of its desired velocities."""
    world = world_of(20, 0.3, 0.4)
    simulation = Simulation(world, 1, engine)
    simulation.reset(4)
    generator = np.random.default_rng(8)
    commands = generator.uniform(-1, 1, (1, 20, 2)) * [0.09, 1.6]
    mass, inertia = 0.14, 0.5 * 0.14 * RADIUS**2
    desired = 0.5 * (mass * commands[..., 0] ** 2 + inertia * commands[..., 1] ** 2).sum()
    for _ in range(200):
        before = simulation.poses[0].copy()
        simulation.step(commands)
        velocity = (simulation.poses[0] - before) / 0.1
        energy = 0.5 * (mass * (velocity[:, :2] ** 2).sum() + inertia * (velocity[:, 2] ** 2).sum())
        assert energy < desired * 1.02


def test_two_robots_collide_alike_in_both_engines() -> None:
    generator = np.random.default_rng(3)
    for _ in range(60):
        angle = generator.uniform(0, 2 * np.pi)
        first = [0.85, 0.7, generator.uniform(0, 2 * np.pi)]
        second = [0.85 + 0.16 * np.cos(angle), 0.7 + 0.16 * np.sin(angle), angle + np.pi + generator.uniform(-0.8, 0.8)]
        first[2] = angle + generator.uniform(-0.8, 0.8)
        commands = [[0.09, generator.uniform(-0.5, 0.5)], [0.09, generator.uniform(-0.5, 0.5)]]
        world = world_of(2, 0.3, 0.4)
        one, other = (run(world, engine, [first, second], commands, 20)[-1] for engine in ENGINES)
        assert np.linalg.norm(one[:, :2] - other[:, :2], axis=1).max() < 5e-3
        assert np.abs(one[:, 2] - other[:, 2]).max() < np.radians(5)


def test_a_robot_meets_a_wall_alike_in_both_engines() -> None:
    generator = np.random.default_rng(4)
    for _ in range(60):
        start = [[0.85, 0.09, generator.uniform(-np.pi, 0)]]
        commands = [[0.09, generator.uniform(-0.8, 0.8)]]
        world = world_of(1, 0.3, 0.4)
        one, other = (run(world, engine, start, commands, 20)[-1, 0] for engine in ENGINES)
        assert np.linalg.norm(one[:2] - other[:2]) < 5e-3
        assert abs(one[2] - other[2]) < np.radians(5)

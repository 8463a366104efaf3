"""Whatever robots do in any shipped world: nobody leaves, nobody overlaps, and contact only ever takes motion away."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_envs import Simulation, load_world, world_names
from swarm_envs.simulation.chipmunk.prediction import CONTACT_MARGIN
from swarm_envs.worlds import Contact, Effects, RobotModel, WorldSpec

Array = npt.NDArray[np.float64]
ENGINES = ["chipmunk", "disc"]
OVERLAP = {"chipmunk": 5e-3, "disc": 1e-3}
"""Greatest overlap in m that each engine promises."""
PHASE = 25
"""Ticks that a command lasts."""
strongly = settings(max_examples=150, deadline=None, derandomize=True)
SHARES = st.sampled_from([-1.0, -0.5, 0.0, 0.5, 1.0])


def with_body(robot: RobotModel, **changes: float) -> RobotModel:
    return dataclasses.replace(robot, body=dataclasses.replace(robot.body, **changes))


def mixed() -> WorldSpec:
    """A heavy disc, a light one and small ones, with strong friction and hard walls that throw back."""
    robot = load_world("hero_plus").robots[0]
    kinds = (with_body(robot, contact_radius=0.12, mass=1.5), with_body(robot, mass=0.02), with_body(robot, contact_radius=0.03))
    return load_world("hero_plus").replace(name="mixed", robots=kinds * 3, contact=Contact(1.0, 2.0, 0.5, 0.8))


WORLDS = {name: load_world(name) for name in world_names()} | {"mixed": mixed()}


class Tick(NamedTuple):
    """What was asked of the robots and where it brought them."""

    commands: Array
    before: Array
    after: Array


@st.composite
def swarms(draw: st.DrawFn) -> tuple[WorldSpec, int, list[Array]]:
    """A world with some robots, the seed of its start, and commands (robots, 2) of some phases."""
    world = WORLDS[draw(st.sampled_from(sorted(WORLDS)))]
    world = world.with_robots(draw(st.integers(1, 12)))
    limits = np.array([world.limits.linear_speed, world.limits.angular_speed])
    phase = st.lists(st.tuples(SHARES, SHARES), min_size=world.num_robots, max_size=world.num_robots)
    phases = draw(st.lists(phase, min_size=1, max_size=5))
    return world, draw(st.integers(0, 2**32)), [np.array(each) * limits for each in phases]


def ticks(swarm: tuple[WorldSpec, int, list[Array]], engine: str) -> Iterator[Tick]:
    world, seed, phases = swarm
    simulation = Simulation(world, 1, engine)
    simulation.reset(seed)
    for commands in phases:
        for _ in range(PHASE):
            before = simulation.poses[0].copy()
            simulation.step(commands[None])
            yield Tick(commands, before, simulation.poses[0].copy())


def body(world: WorldSpec, field: str) -> Array:
    return np.array([getattr(robot.body, field) for robot in world.robots])


def deepest(world: WorldSpec, poses: Array) -> float:
    """Greatest overlap in m of two robots, or of a robot with the rectangle's walls; the world's own arena is one."""
    at, radii = poses[:, :2], body(world, "contact_radius")
    gaps = np.linalg.norm(at[:, None] - at[None], axis=-1) - radii - radii[:, None]
    np.fill_diagonal(gaps, np.inf)
    walls = min((at - radii[:, None]).min(), (np.array(world.size) - radii[:, None] - at).min())
    return -min(float(gaps.min()), float(walls))


@pytest.mark.parametrize("engine", ENGINES)
@strongly
@given(swarm=swarms())
def test_no_robot_of_any_world_is_nowhere_outside_or_inside_another(engine: str, swarm: tuple[WorldSpec, int, list[Array]]) -> None:
    for tick in ticks(swarm, engine):
        assert np.isfinite(tick.after).all()
        assert deepest(swarm[0], tick.after) < OVERLAP[engine]


@pytest.mark.parametrize("engine", ENGINES)
@strongly
@given(swarm=swarms())
def test_contact_never_adds_kinetic_energy_to_what_robots_are_asked(engine: str, swarm: tuple[WorldSpec, int, list[Array]]) -> None:
    """Each tick, summed over robots: m v^2 + I omega^2 of what happened is at most that of what was asked.

    Robots drive as asked, without effects, so the command is the desired velocity. A thousandth covers the solvers' tolerance.
    """
    plain = tuple(dataclasses.replace(robot, effects=Effects()) for robot in swarm[0].robots)
    swarm = (swarm[0].replace(robots=plain), *swarm[1:])
    mass = body(swarm[0], "mass")
    inertia = body(swarm[0], "inertia_ratio") * mass * body(swarm[0], "contact_radius") ** 2
    for tick in ticks(swarm, engine):
        velocity = (tick.after - tick.before) / swarm[0].tick
        happened = mass * (velocity[:, :2] ** 2).sum(axis=1) + inertia * velocity[:, 2] ** 2
        desired = mass * tick.commands[:, 0] ** 2 + inertia * tick.commands[:, 1] ** 2
        # a robot that stands may still be eased out of an overlap, at no more than a millimetre per second
        assert happened.sum() <= 1.001 * desired.sum() + (mass * 1e-3**2).sum()


def glide(first: Array, second: Array, desired: Array, mass: Array, seconds: float, reach: float) -> Array:
    """Centres (2, 2) of two touching frictionless discs after a time, in closed form.

    Their common centre of mass keeps its velocity. Their relative desired velocity u drags the line of centres round at
    u sin(a) / reach, a its angle to u: tan(a / 2) falls as exp(-u t / reach) backwards in time, until a = 90 degrees lets them part
    along u.
    """
    apart, u = second - first, desired[1] - desired[0]
    speed = float(np.hypot(*u))
    along = u / speed
    across = np.array([-along[1], along[0]])
    angle = float(np.arctan2(apart @ across, apart @ along))
    side = np.sign(angle)
    until = reach / speed * np.log(np.tan(abs(angle) / 2))  # when the angle has fallen to 90 degrees
    touching = min(seconds, until)
    swept = 2 * np.arctan(np.tan(abs(angle) / 2) * np.exp(-speed * touching / reach)) * side
    relative = reach * (np.cos(swept) * along + np.sin(swept) * across) + u * (seconds - touching)
    centre = (mass @ np.stack([first, second]) + mass @ desired * seconds) / mass.sum()
    return np.stack([centre - mass[1] / mass.sum() * relative, centre + mass[0] / mass.sum() * relative])


@pytest.mark.parametrize("engine", ENGINES)
@strongly
@given(
    glance=st.floats(0.1, 1.4),
    side=st.sampled_from([-1, 1]),
    speeds=st.tuples(st.floats(0.03, 0.09), st.floats(0.0, 0.09)),
    ratio=st.sampled_from([1.0, 0.25, 5.0]),
    seconds=st.integers(5, 40),
)
def test_frictionless_discs_that_meet_off_centre_slide_round_each_other_as_geometry_says(
    engine: str, glance: float, side: int, speeds: tuple[float, float], ratio: float, seconds: int
) -> None:
    world = load_world("hero_plus", num_robots=2).replace(contact=Contact())
    world = world.replace(robots=(world.robots[0], with_body(world.robots[1], mass=0.14 * ratio)))
    first, line = np.array([0.85, 0.71]), np.array([np.cos(glance), side * np.sin(glance)])
    start = np.array([[*first, 0.0], [*(first + 0.12 * line), np.pi]])  # towards each other along x, met at an angle to it
    desired = np.array([[speeds[0], 0.0], [-speeds[1], 0.0]])
    simulation = Simulation(world, 1, engine)
    simulation.reset(0, initial_poses=start[None])
    for _ in range(seconds):
        simulation.step(np.array([[[speeds[0], 0.0], [speeds[1], 0.0]]]))
    expected = glide(first, start[1, :2], desired, body(world, "mass"), 0.1 * seconds, 0.12)
    assert np.linalg.norm(simulation.poses[0, :, :2] - expected, axis=1).max() < 1.5e-3
    assert simulation.poses[0, :, 2] == pytest.approx([0.0, np.pi], abs=1e-9), "without friction nothing turns"


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("mu", [0.1, 0.3, 0.6, 1.0])
def test_a_wall_holds_the_point_it_touches_exactly_above_the_critical_angle(engine: str, mu: float) -> None:
    """A robot that drives at angle a into a wall rolls on it where tan a >= 1 / (mu (1 + m r^2 / I)); a uniform disc has m r^2 / I = 2."""
    angles = np.arctan(1 / (3 * mu)) + np.array([-0.15, 0.15])
    world = load_world("hero_plus", num_robots=1).replace(contact=Contact(0.3, mu))
    simulation = Simulation(world, 2, engine)
    simulation.reset(0, initial_poses=np.array([[[0.3, 0.06, -angle]] for angle in angles]))
    for _ in range(2):  # in the first tick a robot may still settle on the wall
        before = simulation.poses[:, 0].copy()
        simulation.step(np.tile([0.09, 0.0], (2, 1, 1)))
    moved = simulation.poses[:, 0] - before
    rim = moved[:, 0] + 0.06 * moved[:, 2]  # way of the touching point: the centre's, less what the turn rolls off
    assert rim[0] > 5e-4
    # for Chipmunk a robot's disc reaches out by a little, and rolls on that rim
    assert abs(rim[1]) < (1e-6 if engine == "disc" else 1.1 * CONTACT_MARGIN / 0.06 * abs(moved[1, 0]))

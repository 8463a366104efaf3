"""Without contact a robot moves on the closed-form arcs, whatever engine runs it."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from swarm_envs import Simulation, load_world
from swarm_envs.worlds import Arena, WorldSpec

ENGINES = ["chipmunk", "disc"]


def field(**effects: float) -> WorldSpec:
    """One robot on a field of 40 m, so that nothing is ever touched."""
    world = load_world("hero_plus", num_robots=1)
    outline = ((-20.0, -20.0), (20.0, -20.0), (20.0, 20.0), (-20.0, 20.0))
    return dataclasses.replace(world, arena=Arena(outline)).with_effects(**effects)


def run(
    world: WorldSpec, engine: str, commands: npt.ArrayLike, start: tuple[float, float, float] = (0.0, 0.0, 0.3)
) -> npt.NDArray[np.float64]:
    simulation = Simulation(world, 1, engine)
    simulation.reset(0, initial_poses=np.array(start).reshape(1, 1, 3))
    poses = [simulation.poses[0, 0].copy()]
    for command in np.asarray(commands, dtype=np.float64):
        simulation.step(command.reshape(1, 1, 2))
        poses.append(simulation.poses[0, 0].copy())
    return np.array(poses)


def arc(v: float, omega: float, seconds: npt.NDArray[np.float64], start: tuple[float, float, float]) -> npt.NDArray[np.float64]:
    """The unicycle's circle about its centre."""
    x, y, heading = start
    turned = heading + omega * seconds
    radius = v / omega
    return np.stack([x + radius * (np.sin(turned) - np.sin(heading)), y - radius * (np.cos(turned) - np.cos(heading)), turned], axis=1)


@settings(max_examples=15, deadline=None)
@given(
    v=st.floats(-0.09, 0.09),
    omega=st.floats(0.01, 1.6).flatmap(lambda w: st.sampled_from([w, -w])),
    heading=st.floats(-3.0, 3.0),
    engine=st.sampled_from(ENGINES),
)
def test_a_minute_of_free_driving_follows_the_circle_to_a_nanometre(v: float, omega: float, heading: float, engine: str) -> None:
    start = (1.0, -2.0, heading)
    poses = run(field(), engine, np.tile([v, omega], (600, 1)), start)
    expected = arc(v, omega, 0.1 * np.arange(601), start)
    assert np.abs(poses - expected).max() < 1e-9


@pytest.mark.parametrize("engine", ENGINES)
def test_straight_driving_is_straight(engine: str) -> None:
    poses = run(field(), engine, np.tile([0.09, 0.0], (600, 1)), (0.0, 0.0, 0.5))
    assert poses[-1] == pytest.approx([5.4 * np.cos(0.5), 5.4 * np.sin(0.5), 0.5], abs=1e-9)


def fine_reference(commands: npt.NDArray[np.float64], effects: dict[str, float], wheel_base: float) -> npt.NDArray[np.float64]:
    """Poses after each tick by Euler steps of 0.1 ms of the documented equations, written without looking at the compiled code."""
    step = 1e-4
    x, y, heading, v_now, omega_now = 0.0, 0.0, 0.3, 0.0, 0.0
    poses = [(x, y, heading)]
    per_tick = round(0.1 / step)
    for k in range(len(commands) * per_tick):
        when = (k + 0.5) * step - effects.get("dead_time", 0.0)
        v, omega = commands[int(when / 0.1)] if when >= 0 else (0.0, 0.0)
        left, right = v - omega * wheel_base / 2, v + omega * wheel_base / 2
        left, right = (0.0 if abs(rim) < effects.get("deadband", 0.0) else rim for rim in (left, right))
        v, omega = (left + right) / 2, (right - left) / wheel_base
        v *= 1 - effects.get("turning_slows", 0.0) * abs(omega)
        drift = 1 - effects.get("gain_drift", 0.0) * (k // per_tick) * 0.1
        v *= effects.get("linear_gain", 1.0) * drift
        omega *= effects.get("angular_gain", 1.0) * drift
        limit = effects.get("saturation", np.inf)
        left, right = np.clip([v - omega * wheel_base / 2, v + omega * wheel_base / 2], -limit, limit)
        v, omega = (left + right) / 2, (right - left) / wheel_base
        lag = effects.get("motor_lag", 0.0)
        share = 1 - np.exp(-step / lag) if lag else 1.0
        v_now, omega_now = v_now + share * (v - v_now), omega_now + share * (omega - omega_now)
        turn = omega_now + effects.get("turn_bias", 0.0) * v_now
        x += v_now * np.cos(heading + turn * step / 2) * step
        y += v_now * np.sin(heading + turn * step / 2) * step
        if v != 0 or omega != 0:
            x += effects.get("floor_drift_x", 0.0) * step
            y += effects.get("floor_drift_y", 0.0) * step
        heading += turn * step
        if (k + 1) % per_tick == 0:
            poses.append((x, y, heading))
    return np.array(poses)


EFFECTS = [
    {"linear_gain": 0.9},
    {"angular_gain": 1.1},
    {"turn_bias": 0.8},
    {"dead_time": 0.23},
    {"dead_time": 0.3},
    {"motor_lag": 0.25},
    {"deadband": 0.02},
    {"saturation": 0.06},
    {"gain_drift": 0.01},
    {"floor_drift_x": 0.01, "floor_drift_y": -0.02},
    {"turning_slows": 0.3},
    {"motor_lag": 0.15, "dead_time": 0.13, "linear_gain": 0.8, "turn_bias": -0.5, "deadband": 0.01},
]


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("effects", EFFECTS, ids=lambda effects: "+".join(effects))
def test_each_drive_effect_moves_the_robot_as_its_equation_says(effects: dict[str, float], engine: str) -> None:
    commands = np.repeat([[0.08, 0.0], [0.05, 0.9], [0.0, 0.0], [-0.06, -1.5], [0.03, 0.2], [0.0, 1.2]], 10, axis=0)
    world = field(**effects)
    poses = run(world, engine, commands)
    ideal = run(field(), engine, commands)
    expected = fine_reference(commands, effects, world.robots[0].drive.wheel_base)
    assert np.abs(ideal[-1] - expected[-1]).max() > 3e-3, "the effect must show at all"
    assert np.abs(poses - expected).max() < 3e-4


def test_both_engines_move_a_free_robot_alike_with_every_effect_at_once() -> None:
    world = field(motor_lag=0.2, dead_time=0.17, turn_bias=0.4, linear_gain=0.9, saturation=0.08, command_loss=0.2, start_kick_sd=0.1)
    commands = np.random.default_rng(5).uniform(-1, 1, (600, 2)) * [0.09, 1.6]
    assert np.abs(run(world, "chipmunk", commands) - run(world, "disc", commands)).max() < 1e-6


def test_a_lost_command_leaves_the_previous_one_in_force_as_often_as_asked() -> None:
    commands = np.tile([[0.0, 1.0], [0.0, -1.0]], (2000, 1))
    turns = np.diff(run(field(command_loss=0.3), "disc", commands)[:, 2])
    kept = np.sign(turns[1:]) != np.sign(commands[1:, 1])
    # a loss shows when the command before the lost one was not lost in turn: p (1 - p) + p^3 (1 - p) + ... = p / (1 + p)
    assert kept.mean() == pytest.approx(0.3 / 1.3, abs=0.03)


def test_a_start_from_rest_kicks_with_the_asked_mean_and_spread() -> None:
    commands = np.tile([[0.05, 0.0], [0.0, 0.0]], (1500, 1))
    turns = np.diff(run(field(start_kick_mean=0.1, start_kick_sd=0.05), "disc", commands)[:, 2])
    assert turns[1::2] == pytest.approx(0.0, abs=1e-12)
    assert turns[::2].mean() == pytest.approx(0.1, abs=0.005)
    assert turns[::2].std() == pytest.approx(0.05, abs=0.005)


def test_gain_spread_gives_every_robot_its_own_gain_for_the_whole_run() -> None:
    world = dataclasses.replace(load_world("hero_plus", num_robots=8)).with_effects(linear_gain_spread=0.1)
    simulation = Simulation(world, 200, "disc")
    simulation.reset(1)
    before = simulation.poses.copy()
    simulation.step(np.tile([0.05, 0.0], (200, 8, 1)))
    first = np.hypot(*(simulation.poses - before)[..., :2].transpose(2, 0, 1)) / 0.005
    before = simulation.poses.copy()
    simulation.step(np.tile([0.05, 0.0], (200, 8, 1)))
    second = np.hypot(*(simulation.poses - before)[..., :2].transpose(2, 0, 1)) / 0.005
    assert first == pytest.approx(second, abs=1e-9)
    assert first.std() == pytest.approx(0.1, rel=0.1)
    assert first.mean() == pytest.approx(1.0, abs=0.02)

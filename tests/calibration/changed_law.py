"""Drives a robot by every code that moves robots, with a law of motion changed in one place; prints where it ends up, as JSON.

The same for the sensor's law: how often a robot in view is missed, and one reported where there is none.

Run without compilation (``NUMBA_DISABLE_JIT=1``): a law is then a plain function, whose code is exchanged for another.
"""

from __future__ import annotations

import ctypes
import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from swarm_envs import Simulation, load_world
from swarm_envs.calibration.drive.filter import filter_log
from swarm_envs.calibration.drive.measured import Measured
from swarm_envs.calibration.drive.motion import free_run
from swarm_envs.calibration.drive.parameters import drive_parameters
from swarm_envs.calibration.logs.log import Track
from swarm_envs.calibration.sensor.error_probabilities import false_detection_probability, miss_probabilities
from swarm_envs.simulation import drive_law, sensor_law
from swarm_envs.simulation.chipmunk import engine as chipmunk
from swarm_envs.simulation.effect_rows import effect_rows
from swarm_envs.simulation.trigonometry import sinc
from swarm_envs.worlds import WorldSpec

EFFECTS = {
    "ideal": {},
    "without lag": {
        "linear_gain": 0.9, "angular_gain": 1.1, "turn_bias": 0.4, "dead_time": 0.13, "deadband": 0.02, "saturation": 0.11,
        "turning_slows": 0.05, "floor_drift_x": 0.01, "start_kick_mean": 0.2,
    },
    "with lag": {"motor_lag": 0.2, "linear_gain": 0.9, "turn_bias": 0.4},
}  # fmt: skip
START = (0.85, 0.71, 0.3)
COMMANDS = ((0.08, 1.2), (-0.05, 0.4), (0.0, 0.0), (0.09, -0.8))
"""Each for half a second: v in m/s and omega in rad/s."""
TICKS = 20

WORLDS = 2000
"""Readings of the sensor."""

Poses = dict[str, list[float]]


def goal_velocity(
    effects: Any, wheel_base: float, linear_factor: float, angular_factor: float, v: float, omega: float, now: float, unit: float
) -> tuple[float, float]:
    return 0.5 * v, 0.5 * omega


def stand_below_deadband(v: float, omega: float, threshold: float, wheel_base: float) -> tuple[float, float]:
    return 0.8 * v, omega


def clip_rims(v: float, omega: float, limit: float, wheel_base: float) -> tuple[float, float]:
    return v, 0.7 * omega


def first_order(now: float, goal: float, duration: float, time_constant: float) -> tuple[float, float]:
    return 1.2 * goal, 1.2 * goal


def chord_speed(v: float, half_turn: float) -> float:
    return 1.1 * v * sinc(half_turn)


def time_of_effect(effects: Any, given: float) -> float:
    return given + 0.3


def start_kick(effects: Any, draw: float) -> float:
    return -0.4


def floor_drift(effects: Any, duration: float) -> tuple[float, float]:
    return -0.02 * duration, 0.03 * duration


def miss_probability(effects: Any, share: float, v: float, omega: float) -> float:
    return 0.8 - 0.4 * share


def false_probability(effects: Any) -> float:
    return 0.35


CHANGES: dict[str, Callable[..., Any]] = {
    each.__name__: each
    for each in (goal_velocity, stand_below_deadband, clip_rims, first_order, chord_speed, time_of_effect, start_kick, floor_drift)
}


def call_chipmunk_from_python() -> None:
    """Let the engine's loop, which is not compiled here, call the C library as compiled code does."""
    with_pointers = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
    with_double = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_double)
    chipmunk.__dict__["call_with_pointers"] = lambda at, *pointers: with_pointers(int(at))(*map(int, pointers))
    chipmunk.__dict__["call_with_double"] = lambda at, pointer, number: with_double(int(at))(int(pointer), number)


@contextmanager
def changed(law: Any, other: Any) -> Iterator[None]:
    """Exchange the code of a law; whoever has imported the function runs the other code."""
    before = law.__code__
    law.__code__ = other.__code__
    try:
        yield
    finally:
        law.__code__ = before


def simulated(world: WorldSpec, engine: str) -> NDArray[np.float64]:
    """The pose after all commands, by an engine."""
    simulation = Simulation(world, 1, engine)
    simulation.reset(0, initial_poses=np.array([[START]]))
    for command in np.repeat(np.array(COMMANDS), TICKS // len(COMMANDS), axis=0):
        simulation.step(command[None, None])
    return simulation.poses[0, 0].copy()


def predicted(world: WorldSpec) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The same by calibration's prediction and by its filter, which sees the start alone."""
    given = 0.5 * np.arange(len(COMMANDS))
    times, poses = np.array([0.0, 0.1 * TICKS]), np.array([START, START])
    parameters, commands = drive_parameters(world), np.array(COMMANDS)
    track = Track("run", "robot", times, poses, given, commands, np.empty(0), np.empty(0, bool))
    one = np.zeros(1, np.int64)
    data = Measured(
        times=times, poses=poses, first=np.array([0, 2]), command_times=given, commands=commands, command_first=np.array([0, len(given)]),
        touching=np.zeros(2, bool), robot=one, run=one, robots=("robot",), runs=("run",),
    )  # fmt: skip
    innovation = filter_log(parameters, np.array([1e-3, 5e-3, 3e-3, 2e-3, 3e-2]), np.ones((1, 2)), data).innovation[1]
    return free_run(parameters, track).from_pose(0, poses[0], np.array([1]))[0], poses[1] - innovation


def ends(effects: dict[str, float]) -> Poses:
    world = load_world("hero_plus", num_robots=1).with_effects(**effects)
    prediction, filtered = predicted(world)
    ways = {"disc": simulated(world, "disc"), "chipmunk": simulated(world, "chipmunk"), "prediction": prediction, "filter": filtered}
    return {way: pose.tolist() for way, pose in ways.items()}


def wrong_readings() -> dict[str, dict[str, float]]:
    """How often a robot at half of its neighbour's range is missed, and how often that neighbour, with its back to the first, reports one.

    Each is counted in the simulation, and as calibration has it.
    """
    world = load_world("hero_plus", num_robots=2).with_effects(missed_detections=0.3, misses_at_full_range=0.4, false_detections=0.1)
    distance = 0.5 * world.robots[0].sensors[0].range
    simulation = Simulation(world, WORLDS, "disc")
    simulation.reset(3, initial_poses=np.tile([(0.4, 0.7, 0.0), (0.4 + distance, 0.7, 0.0)], (WORLDS, 1, 1)))
    miss, rows = np.empty(1), effect_rows([world.robots[0].effects])
    miss_probabilities(rows, np.array([0.5]), np.zeros(1), np.zeros(1), miss)
    in_view, nothing_in_view = simulation.detections.mean(axis=0).tolist()
    return {
        "missed": {"simulation": 1.0 - in_view, "calibration": float(miss[0])},
        "false": {"simulation": nothing_in_view, "calibration": float(false_detection_probability(rows))},
    }


if __name__ == "__main__":
    call_chipmunk_from_python()
    found: dict[str, dict[str, Any]] = {"": {name: ends(effects) for name, effects in EFFECTS.items()}}
    for change in CHANGES:
        with changed(getattr(drive_law, change), CHANGES[change]):
            found[change] = {"without lag": ends(EFFECTS["without lag"])}
            if change == "chord_speed":
                found[change]["ideal"] = ends({})
    found["sensor"] = {"as declared": wrong_readings()}
    with changed(sensor_law.miss_probability, miss_probability), changed(sensor_law.false_probability, false_probability):
        found["sensor"]["changed"] = wrong_readings()
    print(json.dumps(found))

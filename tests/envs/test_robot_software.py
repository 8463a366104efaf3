"""The environment with the robot's own firmware at the wheel."""

from __future__ import annotations

import shutil
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import swarm_envs
from swarm_envs import behaviours
from swarm_envs.envs import SwarmEnv

CONTROLLER = [0.07, -1.3, 0.06, 1.1]
needs_compiler = pytest.mark.skipif(
    shutil.which("cc") is None, reason="the firmware is built with the system's C compiler, which is absent"
)


def run(seed: int, ticks: int = 600, **arguments: Any) -> np.ndarray:
    env = gym.make("HeRo/Swarm-v0", robot_software="firmware", controller=CONTROLLER, disable_env_checker=True, **arguments)
    _, info = env.reset(seed=seed)
    frames = [info["poses"]]
    frames += [env.step(0)[4]["poses"] for _ in range(ticks)]
    return np.array(frames)


@needs_compiler
def test_gymnasiums_checker_has_nothing_to_say_about_self_driven_robots() -> None:
    check_env(gym.make("HeRo/Swarm-v0", robot_software="firmware", controller=CONTROLLER).unwrapped, skip_render_check=True)


@needs_compiler
def test_cyclic_pursuit_emerges_with_the_firmware_at_the_wheel() -> None:
    labels = []
    for seed in range(4):
        poses = run(seed)[None]
        template = swarm_envs.rollouts("hero_plus", [CONTROLLER])
        named = type(template)(template.world, "chipmunk", template.time, poses, template.detections, template.commands)
        labels += behaviours.label(named)
    assert labels.count("cyclic pursuit") >= 3


@needs_compiler
def test_the_same_seed_gives_the_same_bits_and_robots_drive_at_their_controllers_speed() -> None:
    first, second = run(1, 100), run(1, 100)
    assert (first == second).all()
    alone = run(1, 60, num_robots=1)
    chord = np.hypot(*np.diff(alone, axis=0)[20:, 0, :2].T) / 0.1
    assert chord.mean() == pytest.approx(0.07 * np.sinc(0.065 / np.pi), abs=0.001)


@needs_compiler
@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"robot_software": "firmware"}, "needs controller="),
        ({"controller": CONTROLLER, "robot_software": "actions"}, "controller is given, but robot_software is 'actions'"),
        ({"robot_software": "ros"}, "robot_software is 'ros', expected one of actions, controller, firmware"),
        ({"robot_software": "firmware", "controller": [0.5, 0, 0, 0]}, "v of 0.5 m/s is outside the limits"),
    ],
)
def test_wrong_software_is_refused_in_one_line(arguments: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint) as error:
        SwarmEnv(**arguments)
    assert "\n" not in str(error.value)

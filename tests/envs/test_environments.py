"""The environments keep the official contracts, without one warning."""

from __future__ import annotations

import warnings
from typing import Any

import gymnasium as gym
import numpy as np
import pettingzoo
import pytest
from gymnasium.utils.env_checker import check_env
from pettingzoo.test import parallel_api_test, parallel_seed_test

import swarm_envs
from swarm_envs.envs import SwarmEnv, SwarmParallelEnv, register_environments


@pytest.fixture(autouse=True)
def warnings_are_errors() -> object:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # what other tests of this process left open may be collected at any time
        warnings.simplefilter("ignore", ResourceWarning)
        yield


def test_gymnasiums_checker_has_nothing_to_say() -> None:
    check_env(gym.make("HeRo/Swarm-v0", render_mode="rgb_array").unwrapped)


def test_pettingzoos_parallel_tests_pass() -> None:
    parallel_api_test(SwarmParallelEnv(), num_cycles=1300)
    parallel_seed_test(SwarmParallelEnv)


def test_both_registries_know_the_swarm_and_registering_twice_changes_nothing() -> None:
    register_environments()
    assert gym.make("swarm_envs:HeRo/Swarm-v0").unwrapped.world.name == "hero_plus"
    assert len(pettingzoo.make("parallel", "HeRo/Swarm-v0").possible_agents) == 8


def test_pictures_have_the_papers_size() -> None:
    single, many = gym.make("HeRo/Swarm-v0", render_mode="rgb_array"), SwarmParallelEnv(render_mode="rgb_array")
    single.reset(seed=0)
    many.reset(seed=0)
    for picture in (single.render(), many.render()):
        assert picture.shape == (426, 513, 3)
        assert picture.dtype == np.uint8
        assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 20


def test_spaces_are_the_worlds_limits_and_the_binary_detections() -> None:
    env = gym.make("HeRo/Swarm-v0", num_robots=5)
    assert env.action_space.shape == (5, 2)
    assert env.observation_space == gym.spaces.MultiBinary(5)
    assert env.action_space.high[0] == pytest.approx([0.09, 1.6])
    assert (env.action_space.high.astype(float) <= [0.09, 1.6]).all(), "float32 must not round beyond the limits"


def test_the_one_agent_and_the_many_move_alike() -> None:
    single, many = gym.make("HeRo/Swarm-v0"), SwarmParallelEnv()
    observation, info = single.reset(seed=11)
    observations, infos = many.reset(seed=11)
    generator = np.random.default_rng(0)
    for _ in range(100):
        assert observation.tolist() == [int(observations[f"robot_{i}"][0]) for i in range(8)]
        assert info["poses"].tolist() == [infos[f"robot_{i}"]["pose"].tolist() for i in range(8)]
        action = generator.uniform(-1, 1, (8, 2)).astype(np.float32) * single.action_space.high
        observation, _, _, _, info = single.step(action)
        observations, _, _, _, infos = many.step({f"robot_{i}": action[i] for i in range(8)})


def test_the_environment_is_the_simulation_that_rollouts_run() -> None:
    env = gym.make("HeRo/Swarm-v0", engine="disc")
    observation, info = env.reset(seed=5, options=None)
    start = info["poses"]
    controller = np.array([0.06, 0.8, 0.09, -0.5])
    for _ in range(200):
        command = np.where(observation[:, None] > 0, controller[2:], controller[:2])
        observation, _, _, _, info = env.step(command)
    rollout = swarm_envs.rollouts("hero_plus", controller[None], initial_poses=start[None], steps=200, engine="disc")
    assert (rollout.poses[0, -1] == info["poses"]).all()


def test_given_start_poses_are_taken() -> None:
    poses = np.array([[0.3 + 0.15 * i, 0.4, 0.1 * i] for i in range(8)])
    _, info = gym.make("HeRo/Swarm-v0").reset(options={"initial_poses": poses})
    assert info["poses"].tolist() == poses.tolist()


def test_an_episode_is_truncated_after_600_ticks() -> None:
    env = gym.make("HeRo/Swarm-v0")
    env.reset(seed=0)
    ends = [env.step(np.zeros((8, 2), np.float32))[2:4] for _ in range(600)]
    assert not any(terminated or truncated for terminated, truncated in ends[:-1])
    assert ends[-1] == (False, True)
    many = SwarmParallelEnv()
    many.reset(seed=0)
    for _ in range(600):
        *_, truncations, _ = many.step({agent: np.zeros(2) for agent in many.agents})
    assert all(truncations.values())
    assert many.agents == []


@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_an_action_that_is_no_number_is_refused_and_nothing_moves(bad: float) -> None:
    env = gym.make("HeRo/Swarm-v0", disable_env_checker=True)
    _, info = env.reset(seed=0)
    action = np.zeros((8, 2))
    action[3, 1] = bad
    with pytest.raises(ValueError, match=r"action of robot 3 has omega = (nan|inf), expected a finite number"):
        env.step(action)
    assert env.step(np.zeros((8, 2)))[4]["poses"].tolist() == info["poses"].tolist()


def test_actions_beyond_the_limits_are_clipped_to_them() -> None:
    env = gym.make("HeRo/Swarm-v0", num_robots=1, disable_env_checker=True)
    _, before = env.reset(seed=0)
    after = env.step(np.array([[5.0, 0.0]]))[4]
    assert np.hypot(*(after["poses"] - before["poses"])[0, :2]) == pytest.approx(0.009)


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        ({"world": "hero_pluss"}, "did you mean 'hero_plus'"),
        ({"render_mode": "ansi"}, "render_mode is 'ansi', expected 'human', 'rgb_array' or None"),
        ({"engine": "bullet"}, "engine is 'bullet', expected one of chipmunk, disc"),
        ({"num_robots": 0}, "num_robots is 0, expected a whole number from 1 to 1000"),
    ],
)
def test_wrong_arguments_are_refused_in_one_line(arguments: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint) as error:
        SwarmEnv(**arguments)
    assert "\n" not in str(error.value)


def test_a_missing_agents_action_is_refused() -> None:
    many = SwarmParallelEnv()
    many.reset(seed=0)
    with pytest.raises(ValueError, match="actions lack 'robot_7'"):
        many.step({agent: np.zeros(2) for agent in many.agents[:-1]})

"""A discovered controller at the wheel: on board, or as a policy outside."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pettingzoo
import pytest
from gymnasium.utils.env_checker import check_env

import swarm_envs
from swarm_envs.policies import ControllerPolicy
from swarm_envs.worlds import load_world

CONTROLLER = [0.07, -1.3, 0.06, 1.1]


@pytest.mark.parametrize("engine", ["chipmunk", "disc"])
def test_robots_with_a_controller_on_board_move_as_in_a_rollout(engine: str) -> None:
    rolled = swarm_envs.rollouts("hero_plus", [CONTROLLER], seed=3, engine=engine, steps=80)
    env = gym.make("HeRo/Swarm-v0", controller=CONTROLLER, engine=engine)
    _, info = env.reset(seed=0, options={"initial_poses": rolled.poses[0, 0]})
    for tick in range(1, 81):
        info = env.step(0)[4]
        assert np.array_equal(info["poses"], rolled.poses[0, tick])


def test_gymnasiums_checker_has_nothing_to_say_about_it() -> None:
    check_env(gym.make("HeRo/Swarm-v0", controller=CONTROLLER).unwrapped, skip_render_check=True)


@pytest.mark.parametrize("name", ["HeRo/Swarm-v0", "HeRo/Milling-v0"])
def test_the_policy_gives_gymnasium_actions_that_move_robots_as_the_controller_does(name: str) -> None:
    on_board, policy = gym.make(name, controller=CONTROLLER), ControllerPolicy(CONTROLLER)
    outside = gym.make(name)
    (seen, info), (_, expected) = outside.reset(seed=1), on_board.reset(seed=1)
    for _ in range(100):
        action = policy(seen)
        assert outside.action_space.contains(action)
        seen, *_, info = outside.step(action)
        expected = on_board.step(0)[4]
    assert np.allclose(info["poses"], expected["poses"], atol=1e-4), "they differ by the rounding of actions to float32"


def test_the_policy_gives_pettingzoo_and_vector_environments_the_same_actions() -> None:
    policy = ControllerPolicy(CONTROLLER)
    parallel = pettingzoo.make("parallel", "HeRo/Swarm-v0")
    seen, _ = parallel.reset(seed=2)
    actions = policy(seen)
    assert all(parallel.action_space(agent).contains(action) for agent, action in actions.items())
    swarm = np.array([seen[agent][0] for agent in parallel.possible_agents])
    assert np.array_equal(policy(swarm), np.stack([actions[agent] for agent in parallel.possible_agents]))
    parallel.step(actions)
    copies = gym.make_vec("HeRo/Swarm-v0", num_envs=5, vectorization_mode="vector_entry_point")
    many, _ = copies.reset(seed=2)
    assert copies.action_space.contains(policy(many))
    assert np.array_equal(policy(many)[3], policy(many[3]))


def test_the_policy_knows_several_readings_a_controller_for_each_robot_and_full_speed() -> None:
    heard = load_world("hero_plus")
    swarm = ControllerPolicy(np.arange(32).reshape(8, 4) / 400, heard)
    assert swarm.act([1], robot=7).tolist() == pytest.approx([30 / 400, 31 / 400])
    assert swarm(np.zeros(8, np.int8))[2].tolist() == pytest.approx([8 / 400, 9 / 400])
    fastest = ControllerPolicy([0.09, 1.6, -0.09, -1.6])
    assert gym.make("HeRo/Swarm-v0").action_space.contains(fastest(np.array([0, 1] * 4, np.int8)))


@pytest.mark.parametrize(
    ("controller", "complaint"),
    [([0.5, 0, 0, 0], "v of 0.5 m/s is outside the limits"), ([0.05, 0, 0], "expected"), ([0.05, 0, np.nan, 0], "not finite")],
)
def test_a_controller_that_robots_cannot_follow_is_refused(controller: list[float], complaint: str) -> None:
    makers: list[Any] = [ControllerPolicy, lambda given: gym.make("HeRo/Swarm-v0", controller=given)]
    for make in makers:
        with pytest.raises(ValueError, match=complaint):
            make(controller)

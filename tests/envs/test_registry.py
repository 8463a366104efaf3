"""Every registered environment passes every official check, without one warning."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterator
from types import ModuleType
from typing import Any

import gymnasium as gym
import numpy as np
import pettingzoo
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.utils.env_match import check_environments_match
from gymnasium.wrappers import HumanRendering
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test, render_test, seed_test

import swarm_envs
from swarm_envs.envs import ENVIRONMENTS, SwarmEnv, SwarmVectorEnv


@pytest.fixture(autouse=True)
def warnings_are_errors() -> object:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", ResourceWarning)  # what other tests of this process left open may be collected at any time
        yield


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_gymnasiums_checker_has_nothing_to_say(name: str) -> None:
    check_env(gym.make(name, render_mode="rgb_array").unwrapped)


@pytest.fixture
def screenless(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """pygame with windows that need no screen."""
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    pygame: ModuleType = pytest.importorskip("pygame")
    return pygame


@pytest.mark.parametrize("name", ["HeRo/Swarm-v0", "HeRo/Milling-v0"])
@pytest.mark.parametrize("form", ["gymnasium", "parallel"])
def test_a_window_follows_the_swarm(form: str, name: str, screenless: ModuleType) -> None:
    if form == "gymnasium":
        env = gym.make(name, render_mode="human")
        assert not any(isinstance(layer, HumanRendering) for layer in layers(env)), "the window is the environment's own"
    else:
        env = pettingzoo.make("parallel", name, render_mode="human")
    env.reset(seed=0)
    assert screenless.display.get_caption()[0] == name
    before = screenless.surfarray.array3d(screenless.display.get_surface())
    assert before.shape == (513, 426, 3)
    for _ in range(3):
        forward = np.array([0.09, 0.0], np.float32)
        env.step(np.tile(forward, (8, 1)) if form == "gymnasium" else dict.fromkeys(env.agents, forward))
    assert (screenless.surfarray.array3d(screenless.display.get_surface()) != before).any()
    assert env.render() is None
    env.close()
    assert not screenless.display.get_init()


def layers(env: gym.Env[Any, Any]) -> Iterator[gym.Env[Any, Any]]:
    """An environment, what it wraps, and so on."""
    yield env
    while isinstance(env, gym.Wrapper):
        env = env.env
        yield env


def test_gymnasiums_checker_has_nothing_to_say_about_the_window(screenless: ModuleType) -> None:
    env = gym.make("HeRo/Swarm-v0", render_mode="human")
    check_env(env.unwrapped)
    env.close()


def test_a_window_without_pygame_is_refused_in_one_line(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pygame", None)
    with pytest.raises(ImportError, match="render_mode is 'human', which needs pygame") as error:
        gym.make("HeRo/Aggregation-v0", render_mode="human")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("world", swarm_envs.world_names())
def test_gymnasiums_checker_has_nothing_to_say_about_any_world(world: str) -> None:
    for engine in ("chipmunk", "disc"):
        check_env(gym.make("HeRo/Dispersal-v0", world=world, engine=engine, render_mode="rgb_array").unwrapped)


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_pettingzoos_parallel_tests_pass(name: str) -> None:
    parallel_api_test(pettingzoo.make("parallel", name), num_cycles=700)
    parallel_seed_test(lambda: pettingzoo.make("parallel", name))


@pytest.mark.parametrize("name", ENVIRONMENTS)
def test_pettingzoos_aec_tests_pass(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")  # a window without a screen
    # one bit, often zero, is what the robot's sensor gives; PettingZoo wonders at so small an observation
    for remark in ("Observation is a single number", "Observation numpy array is all zeros"):
        warnings.filterwarnings("ignore", remark, UserWarning)
    api_test(pettingzoo.make("aec", name, num_robots=3), num_cycles=100)
    seed_test(lambda: pettingzoo.make("aec", name, num_robots=3), num_cycles=50)
    render_test(lambda **arguments: pettingzoo.make("aec", name, num_robots=3, **arguments))


def test_agents_in_turn_move_as_agents_at_once() -> None:
    turns, once = (pettingzoo.make(form, "HeRo/Aggregation-v0", num_robots=3) for form in ("aec", "parallel"))
    turns.reset(seed=4)
    once.reset(seed=4)
    generator = np.random.default_rng(0)
    for _ in range(20):
        actions = {agent: generator.uniform(-0.05, 0.05, 2).astype(np.float32) for agent in once.agents}
        _, rewards, *_ = once.step(actions)
        for agent in list(turns.agents):
            assert turns.agent_selection == agent
            turns.step(actions[agent])
        assert turns.rewards == rewards
        assert (turns.state() == once.state()).all()


@pytest.mark.parametrize("name", ["HeRo/Swarm-v0", "HeRo/Aggregation-v0"])
def test_gymnasium_finds_scalar_and_vector_environments_equal(name: str) -> None:
    task = ENVIRONMENTS[name]

    class One(SwarmVectorEnv):
        """The native vector environment of one copy, seen as a scalar one."""

    scalar = SwarmEnv(engine="disc", task=task)
    native = One(1, engine="disc", task=task, max_episode_steps=None)

    class Unwrapped(gym.Env):  # type: ignore[type-arg]
        observation_space, action_space = native.single_observation_space, native.single_action_space

        def reset(self, *, seed=None, options=None):  # type: ignore[no-untyped-def]
            super().reset(seed=seed)
            observations, infos = native.reset(seed=seed, options=options)
            return observations[0], self.info(infos)

        def step(self, action):  # type: ignore[no-untyped-def]
            observations, rewards, terminated, truncated, infos = native.step(action[None])
            return observations[0], float(rewards[0]), bool(terminated[0]), bool(truncated[0]), self.info(infos)

        @staticmethod
        def info(infos):  # type: ignore[no-untyped-def]
            return {"poses": infos["poses"][0], "time": float(infos["time"][0])}

    check_environments_match(scalar, Unwrapped(), num_steps=300, seed=3, info_comparison="equivalence")


def test_nobody_downstream_can_write_into_the_environment() -> None:
    many = pettingzoo.make("parallel", "HeRo/Swarm-v0")
    first, infos = many.reset(seed=0)
    assert {frozenset(info) for info in infos.values()} == {frozenset(next(iter(infos.values())))}, "the same keys for every agent"
    first.clear()
    infos["robot_0"]["pose"][:] = np.nan  # RLlib writes into what it gets
    observations, rewards, terminations, truncations, _ = many.step({agent: np.zeros(2, np.float32) for agent in many.agents})
    assert set(observations) == set(rewards) == set(terminations) == set(truncations) == set(many.possible_agents)
    assert np.isfinite(many.state()).all()
    assert many.state_space.contains(many.state())

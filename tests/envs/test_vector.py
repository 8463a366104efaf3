"""The native vector environment is the scalar one, many times."""

from __future__ import annotations

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode, SyncVectorEnv

from swarm_envs.envs import SwarmVectorEnv

MODES = [AutoresetMode.NEXT_STEP, AutoresetMode.SAME_STEP]
TICKS = 40


def scalar(**arguments: Any) -> gym.Env[Any, Any]:
    return gym.make("HeRo/Swarm-v0", engine="disc", disable_env_checker=True, max_episode_steps=TICKS, **arguments)


@pytest.mark.parametrize("mode", MODES)
def test_every_bit_equals_that_of_scalar_environments_across_episodes(mode: AutoresetMode) -> None:
    native = SwarmVectorEnv(3, max_episode_steps=TICKS, autoreset_mode=mode)
    plain = SyncVectorEnv([scalar] * 3, autoreset_mode=mode)
    mine, my_infos = native.reset(seed=5)
    theirs, their_infos = plain.reset(seed=5)
    generator = np.random.default_rng(0)
    for _ in range(3 * TICKS):
        assert (mine == theirs).all()
        assert (my_infos["poses"] == their_infos["poses"]).all()
        actions = generator.uniform(-1, 1, (3, 8, 2)).astype(np.float32) * native.single_action_space.high
        mine, *my_rest, my_infos = native.step(actions)
        theirs, *their_rest, their_infos = plain.step(actions)
        assert all((a == b).all() for a, b in zip(my_rest, their_rest, strict=True))
        assert ("final_obs" in my_infos) == ("final_obs" in their_infos)
        if "final_obs" in my_infos:
            assert all((a == b).all() for a, b in zip(my_infos["final_obs"], their_infos["final_obs"], strict=True))
            assert (my_infos["final_info"]["poses"] == their_infos["final_info"]["poses"]).all()


def test_without_autoreset_a_finished_copy_waits_for_a_masked_reset() -> None:
    native = SwarmVectorEnv(2, max_episode_steps=2, autoreset_mode=AutoresetMode.DISABLED)
    native.reset(seed=0)
    still = np.zeros((2, 8, 2))
    native.step(still)
    *_, truncated, infos = native.step(still)
    assert truncated.all()
    with pytest.raises(ValueError, match="copy 0 is over and autoreset is disabled"):
        native.step(still)
    _, after = native.reset(options={"reset_mask": np.array([True, True])})
    assert (after["poses"] != infos["poses"]).any(axis=(1, 2)).all()
    native.step(still)


def test_make_vec_uses_the_native_environment() -> None:
    native = gym.make_vec("HeRo/Swarm-v0", num_envs=4, vectorization_mode="vector_entry_point", num_robots=3)
    assert isinstance(native.unwrapped, SwarmVectorEnv)
    observations, _ = native.reset(seed=1)
    assert observations.shape == (4, 3)
    assert native.action_space.shape == (4, 3, 2)


def test_observations_share_no_memory_with_earlier_ones() -> None:
    native = SwarmVectorEnv(2)
    first, infos = native.reset(seed=0)
    kept, poses = first.copy(), infos["poses"].copy()
    for _ in range(50):
        native.step(native.action_space.sample())
    assert (first == kept).all()
    assert (infos["poses"] == poses).all()


def test_a_copys_bad_action_is_named() -> None:
    native = SwarmVectorEnv(2)
    native.reset(seed=0)
    actions = np.zeros((2, 8, 2))
    actions[1, 3, 0] = np.nan
    with pytest.raises(ValueError, match="action of robot 3 of copy 1 has v = nan"):
        native.step(actions)


def test_each_copy_is_drawn() -> None:
    native = SwarmVectorEnv(2, render_mode="rgb_array")
    native.reset(seed=0)
    assert [picture.shape for picture in native.render() or ()] == [(426, 513, 3)] * 2


def test_a_masked_reset_leaves_the_other_copies_generators_alone() -> None:
    native, twin = SwarmVectorEnv(2), SwarmVectorEnv(2)
    for env in (native, twin):
        env.reset(seed=3)
    native.reset(seed=9, options={"reset_mask": np.array([True, False])})
    assert (native.reset()[1]["poses"][1] == twin.reset()[1]["poses"][1]).all()


def test_numpy_seeds_are_seeds_and_a_step_before_reset_is_refused() -> None:
    native = SwarmVectorEnv(2)
    with pytest.raises(ValueError, match="step was called before reset"):
        native.step(np.zeros((2, 8, 2)))
    first = native.reset(seed=np.int64(3))[1]["poses"]  # type: ignore[arg-type]
    assert (native.reset(seed=3)[1]["poses"] == first).all()

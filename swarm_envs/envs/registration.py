"""Puts the environments into Gymnasium's and PettingZoo's registries."""

from __future__ import annotations

import gymnasium as gym
import pettingzoo

from swarm_envs.envs.parallel import EPISODE_TICKS


def register_environments() -> None:
    """Register every environment once; calling again changes nothing."""
    if "HeRo/Swarm-v0" not in gym.registry:
        gym.register(
            id="HeRo/Swarm-v0",
            entry_point="swarm_envs.envs.swarm:SwarmEnv",
            vector_entry_point="swarm_envs.envs.vector:SwarmVectorEnv",
            max_episode_steps=EPISODE_TICKS,
        )
    if "HeRo/Swarm-v0" not in pettingzoo.parallel_registry:
        pettingzoo.register("parallel", "HeRo/Swarm-v0", entry_point="swarm_envs.envs.parallel:SwarmParallelEnv")

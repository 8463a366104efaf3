"""Puts the environments into Gymnasium's and PettingZoo's registries."""

from __future__ import annotations

import gymnasium as gym
import pettingzoo

from swarm_envs.envs.parallel import EPISODE_TICKS
from swarm_envs.envs.tasks import TASKS, environment_name

ENVIRONMENTS: dict[str, str | None] = {environment_name(task): task for task in (None, *TASKS)}
"""Every id, in Gymnasium and in PettingZoo, and its task."""


def register_environments() -> None:
    """Register every environment once; calling again changes nothing."""
    for name, task in ENVIRONMENTS.items():
        if name not in gym.registry:
            gym.register(
                id=name,
                entry_point="swarm_envs.envs.swarm:SwarmEnv",
                vector_entry_point="swarm_envs.envs.vector:SwarmVectorEnv",
                max_episode_steps=EPISODE_TICKS,
                kwargs={"task": task},
            )
        if name not in pettingzoo.parallel_registry:
            pettingzoo.register("parallel", name, entry_point="swarm_envs.envs.parallel:SwarmParallelEnv", kwargs={"task": task})
        if name not in pettingzoo.aec_registry:
            pettingzoo.register("aec", name, entry_point="swarm_envs.envs.aec:swarm_aec_env", kwargs={"task": task})

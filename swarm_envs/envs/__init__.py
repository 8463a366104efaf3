"""The worlds as Gymnasium and PettingZoo environments."""

from swarm_envs.envs.parallel import SwarmParallelEnv
from swarm_envs.envs.registration import register_environments
from swarm_envs.envs.swarm import SwarmEnv

__all__ = ["SwarmEnv", "SwarmParallelEnv", "register_environments"]

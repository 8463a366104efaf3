"""The worlds as Gymnasium and PettingZoo environments."""

from swarm_envs.envs.parallel import SwarmParallelEnv
from swarm_envs.envs.registration import register_environments
from swarm_envs.envs.swarm import SwarmEnv
from swarm_envs.envs.vector import SwarmVectorEnv

__all__ = ["SwarmEnv", "SwarmParallelEnv", "SwarmVectorEnv", "register_environments"]

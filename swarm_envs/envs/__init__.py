"""The worlds as Gymnasium and PettingZoo environments."""

from swarm_envs.envs.aec import swarm_aec_env
from swarm_envs.envs.parallel import SwarmParallelEnv
from swarm_envs.envs.registration import ENVIRONMENTS, register_environments
from swarm_envs.envs.swarm import SwarmEnv
from swarm_envs.envs.vector import SwarmVectorEnv

__all__ = ["ENVIRONMENTS", "SwarmEnv", "SwarmParallelEnv", "SwarmVectorEnv", "register_environments", "swarm_aec_env"]

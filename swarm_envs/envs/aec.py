"""The swarm as agents that act in turn: the parallel environment through PettingZoo's own conversion."""

from __future__ import annotations

from typing import Any

from pettingzoo import AECEnv
from pettingzoo.utils.conversions import parallel_to_aec

from swarm_envs.envs.parallel import SwarmParallelEnv


def swarm_aec_env(**arguments: Any) -> AECEnv:
    """Return the environment whose agents act one after another; the world moves when all have acted.

    Args:
        **arguments: Those of :class:`swarm_envs.envs.SwarmParallelEnv`.
    """
    return parallel_to_aec(SwarmParallelEnv(**arguments))

"""Environments hold on to nothing, and nothing holds on to them."""

from __future__ import annotations

import gc
import weakref

from swarm_envs.envs import SwarmEnv, SwarmParallelEnv


def test_an_environment_that_is_let_go_is_freed() -> None:
    for kind in (SwarmEnv, SwarmParallelEnv):
        environment = kind()
        environment.reset(seed=0)
        watched = weakref.ref(environment)
        del environment
        gc.collect()
        assert watched() is None, kind.__name__


def test_an_agents_spaces_are_the_same_objects_each_time() -> None:
    many = SwarmParallelEnv()
    assert many.action_space("robot_0") is many.action_space("robot_0")
    assert many.observation_space("robot_0") is many.observation_space("robot_0")

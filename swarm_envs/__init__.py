"""Calibrated worlds of the HeRo+ robot swarm; importing it registers the environments with Gymnasium and PettingZoo.

>>> import gymnasium as gym
>>> import swarm_envs
>>> gym.make("HeRo/Swarm-v0").action_space.shape
(8, 2)

A controller [v0, omega0, v1, omega1] is rolled out in compiled code, one world for each:

>>> runs = swarm_envs.rollouts("hero_plus", [[0.07, -1.3, 0.06, 1.1], [-0.09, -1.2, 0.0, -1.6]])
>>> runs.poses.shape  # worlds, frames, robots, (x, y, heading)
(2, 601, 8, 3)
>>> swarm_envs.behaviours.label(runs)
['cyclic pursuit', 'aggregation']
"""

from swarm_envs import behaviours, metrics, rendering
from swarm_envs.envs import register_environments
from swarm_envs.simulation import Simulation, Trajectories, rollouts
from swarm_envs.worlds import WorldError, WorldSpec, load_world, world_names

__version__ = "0.2.0"
__all__ = [
    "Simulation",
    "Trajectories",
    "WorldError",
    "WorldSpec",
    "behaviours",
    "load_world",
    "metrics",
    "rendering",
    "rollouts",
    "world_names",
]

register_environments()

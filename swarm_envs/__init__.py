"""Calibrated worlds of the HeRo+ robot swarm; importing it registers the environments with Gymnasium and PettingZoo."""

from swarm_envs import behaviours, metrics, rendering
from swarm_envs.envs import register_environments
from swarm_envs.simulation import Simulation, Trajectories, rollouts
from swarm_envs.worlds import WorldError, WorldSpec, load_world, world_names

__version__ = "0.1.0"
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

"""Calibrated worlds of the HeRo+ robot swarm."""

from swarm_envs.simulation import Simulation, Trajectories, rollouts
from swarm_envs.worlds import WorldError, WorldSpec, load_world, world_names

__all__ = ["Simulation", "Trajectories", "WorldError", "WorldSpec", "load_world", "rollouts", "world_names"]

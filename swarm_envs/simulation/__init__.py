"""How worlds move: one contact law, two engines, recorded as trajectories."""

from swarm_envs.simulation.rollouts import check_controllers, rollouts
from swarm_envs.simulation.simulation import ENGINES, Simulation, announce_engine
from swarm_envs.simulation.trajectories import Trajectories

__all__ = ["ENGINES", "Simulation", "Trajectories", "announce_engine", "check_controllers", "rollouts"]

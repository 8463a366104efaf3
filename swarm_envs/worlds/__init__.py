"""World descriptions: what a world is, and nothing about how it moves."""

from swarm_envs.worlds.effects import Effects
from swarm_envs.worlds.errors import WorldError
from swarm_envs.worlds.load import load_robot_file, load_world, world_names
from swarm_envs.worlds.quantity import Provenance
from swarm_envs.worlds.spec import (
    Arena,
    Body,
    Broadcast,
    Contact,
    Drive,
    Limits,
    Obstacle,
    PushableObject,
    RobotModel,
    Sensor,
    Start,
    WorldSpec,
)

__all__ = [
    "Arena",
    "Body",
    "Broadcast",
    "Contact",
    "Drive",
    "Effects",
    "Limits",
    "Obstacle",
    "Provenance",
    "PushableObject",
    "RobotModel",
    "Sensor",
    "Start",
    "WorldError",
    "WorldSpec",
    "load_robot_file",
    "load_world",
    "world_names",
]

"""The numbers of contact that may be named, and the model that they are numbers of."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np

from swarm_envs.calibration.selection.one_number import Effect, Numbers
from swarm_envs.worlds import WorldSpec


@dataclass(frozen=True)
class ContactModel(Numbers):
    """How robots touch; a number that an effect may change has the effect's name."""

    robot_friction: float
    wall_friction: float
    collision_radius: float
    """m."""

    @classmethod
    def of(cls, world: WorldSpec) -> ContactModel:
        """Return a world's contact, with the radius of its first robot."""
        return cls(world.contact.robot_friction, world.contact.wall_friction, world.robots[0].body.contact_radius)

    def rounded(self) -> ContactModel:
        """Return a copy with numbers that differ by what no contact shows made the same."""
        return ContactModel(*(float(np.round(value, 7)) for value in dataclasses.astuple(self)))

    def acting_in(self, world: WorldSpec) -> WorldSpec:
        """Return a world with this contact."""
        contact = dataclasses.replace(world.contact, robot_friction=self.robot_friction, wall_friction=self.wall_friction)
        radius = self.collision_radius
        robots = []
        for robot in world.robots:
            # a body is seen at most as wide as it is
            body = dataclasses.replace(robot.body, contact_radius=radius, visible_radius=min(robot.body.visible_radius, radius))
            robots.append(dataclasses.replace(robot, body=body))
        return world.replace(contact=contact, robots=tuple(robots))


@dataclass(frozen=True)
class ContactEffect(Effect):
    """A number of contact that may be named."""

    grid: tuple[float, ...]
    """Where to search first."""
    relative: bool = False
    """Whether the grid and all distances from a number are shares of it."""


FRICTIONS = (0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 1.0, 1.3)
RADII = tuple(np.linspace(0.65, 1.45, 33).tolist())
EFFECTS: tuple[ContactEffect, ...] = (
    ContactEffect(
        "robot_friction", "coefficient", "contact.robot_friction", "1", 0.04,
        "Robots rub on each other with a coefficient of {coefficient:.3g}.", FRICTIONS,
    ),
    ContactEffect(
        "wall_friction", "coefficient", "contact.wall_friction", "1", 0.04,
        "Walls rub on robots with a coefficient of {coefficient:.3g}.", FRICTIONS,
    ),
    ContactEffect(
        "collision_radius", "radius", "body.contact_radius", "m", 1e-3,
        "Robots touch at {radius:.3g} m from the centre.", RADII, relative=True,
    ),
)  # fmt: skip
"""Numbers of contact, in the order in which they are tried."""
BY_NAME = {effect.name: effect for effect in EFFECTS}

"""A drive as a vector of numbers that can be fitted: a robot's effects as the world declares them, and two numbers more."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.simulation.effect_rows import as_rows, row_type
from swarm_envs.worlds import Effects, WorldSpec
from swarm_envs.worlds.effects import ActsOn
from swarm_envs.worlds.quantity import quantity


@dataclass(frozen=True)
class DriveParameters:
    """What prediction needs to know of a robot."""

    effects: Effects
    """The world's; those of the sensor are along for the ride."""
    wheel_base: float = quantity("m", low=1e-4, high=10.0)
    """Distance between the wheels' contact points; the world's."""
    marker_yaw: float = quantity("rad", 0.0, low=-3.2, high=3.2)
    """Measured heading minus the robot's; the tracker's."""


EXTRA = dataclasses.fields(DriveParameters)[1:]
DECLARED: dict[str, dataclasses.Field[Any]] = {field.name: field for field in (*dataclasses.fields(Effects), *EXTRA)}
"""The declaration of each number, by name."""
PARAMETERS = tuple(DECLARED)
"""Names of the numbers (P,) of a drive's vector, in its order."""
INDEX = {name: index for index, name in enumerate(PARAMETERS)}
"""Where each stands."""
ROW = np.dtype([("effects", row_type(Effects)), *((field.name, np.float64) for field in EXTRA)])
"""A vector as a record."""


def drive_parameters(world: WorldSpec) -> FloatArray:
    """Return the parameters (P,) of a world's first robot, in the order of :data:`PARAMETERS`."""
    robot = world.robots[0]
    return np.array([*dataclasses.astuple(robot.effects), robot.drive.wheel_base, 0.0])


def as_drives(parameters: FloatArray) -> Sequence[DriveParameters]:
    """Return parameters (P,) as the one record that compiled code reads by name."""
    drives: Sequence[DriveParameters] = as_rows(parameters[None], ROW)
    return drives


def with_drive(world: WorldSpec, parameters: FloatArray) -> WorldSpec:
    """Return a world whose robots drive by these parameters (P,); their sensors, and how robots differ, stay."""
    fields = [field.name for field in dataclasses.fields(Effects) if field.metadata["acts_on"] is ActsOn.DRIVE]
    return world.with_effects(**{name: float(parameters[INDEX[name]]) for name in fields})

"""The world with the named effects added, as an ordinary world file.

A candidate's parameter says which number of a world it is; a place such as ``effects.dead_time`` or ``sensors.range`` is a part of a
robot, or of the world, and its field.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Iterator
from typing import Any

from swarm_envs.calibration.contact.candidates import EFFECTS as CONTACT_EFFECTS
from swarm_envs.calibration.drive.candidates import DRIVE_CANDIDATES, SPREAD
from swarm_envs.calibration.selection.causes import Cause, Estimate
from swarm_envs.calibration.sensor.candidates import EFFECTS as SENSOR_EFFECTS
from swarm_envs.worlds import Provenance, WorldSpec

DRIVE_PLACES = {
    (candidate.name, parameter.name): tuple(f"effects.{field}" for field in (parameter.field, *parameter.also))
    for candidate in (*DRIVE_CANDIDATES, SPREAD)
    for parameter in candidate.parameters
    if candidate.world
}
"""Where a world has an effect's number, by the effect's and the parameter's name."""
PLACES = DRIVE_PLACES | {(effect.name, effect.parameter): (effect.place,) for effect in (*SENSOR_EFFECTS, *CONTACT_EFFECTS)}


def apply_effects(world: WorldSpec, causes: Iterable[Cause], source: str) -> WorldSpec:
    """Return a world that carries exactly the named effects beside its own.

    What is wrong with the measurement and not with the robot (``marker_yaw``, ``clock_offset``) does not go in.

    Args:
        world: The world that was calibrated.
        causes: The effects named, with their parameters.
        source: Name of the log, for the sources of the new numbers.
    """
    known = dict(world.provenance)
    for cause in causes:
        for name, number in cause.parameters.items():
            for place in PLACES.get((cause.effect, name), ()):
                world = with_number(world, place, number.estimate)
                known |= dict.fromkeys(_keys(world, place), _origin(number, source))
    return world.replace(name=f"{world.name}_calibrated", description=f"{world.description} Calibrated from {source}.", provenance=known)


def with_number(world: WorldSpec, place: str, number: float) -> WorldSpec:
    """Return a world with the number at a place changed, for every robot where it is a robot's."""
    part, field = place.split(".")
    change = {field: number}
    if part == "contact":
        return world.replace(contact=dataclasses.replace(world.contact, **change))
    return world.replace(
        robots=tuple(dataclasses.replace(robot, **{part: _changed(getattr(robot, part), change)}) for robot in world.robots)
    )


def _changed(part: Any, change: dict[str, float]) -> Any:
    """A robot's part, or each of several alike, with a field changed."""
    return tuple(_changed(each, change) for each in part) if isinstance(part, tuple) else dataclasses.replace(part, **change)


def _keys(world: WorldSpec, place: str) -> Iterator[str]:
    """The keys of a place in a world's provenance."""
    part, field = place.split(".")
    if part == "contact":
        yield place
    elif part == "sensors":
        yield from (f"robot.sensors[{index}].{field}" for index in range(world.num_sensors))
    else:
        yield f"robot.{place}"


def _origin(number: Estimate, source: str) -> Provenance:
    low, high = number.ci95
    return Provenance(number.unit, f"calibrated from {source}, 95 % interval [{low:.4g}, {high:.4g}]")

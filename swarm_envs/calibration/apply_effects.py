"""The world with the named effects added, as an ordinary world file."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from swarm_envs.calibration.selection.causes import Cause, Estimate
from swarm_envs.worlds import Provenance, RobotModel, WorldSpec
from swarm_envs.worlds.dump import world_to_text

EFFECT_FIELDS = {
    ("linear_gain", "gain"): ("linear_gain",),
    ("angular_gain", "gain"): ("angular_gain",),
    ("turn_bias", "bias"): ("turn_bias",),
    ("dead_time", "delay"): ("dead_time",),
    ("motor_lag", "time_constant"): ("motor_lag",),
    ("deadband", "threshold"): ("deadband",),
    ("saturation", "limit"): ("saturation",),
    ("command_loss", "probability"): ("command_loss",),
    ("gain_drift", "rate"): ("gain_drift",),
    ("floor_drift", "vx"): ("floor_drift_x",),
    ("floor_drift", "vy"): ("floor_drift_y",),
    ("start_kick", "mean"): ("start_kick_mean",),
    ("start_kick", "sd"): ("start_kick_sd",),
    ("turning_slows", "slip"): ("turning_slows",),
    ("robot_spread", "sd"): ("linear_gain_spread", "angular_gain_spread"),
    ("sensor_yaw", "yaw"): ("sensor_yaw",),
    ("missed_detections", "probability"): ("missed_detections",),
    ("misses_when_turning", "rate"): ("misses_when_turning",),
    ("false_detections", "probability"): ("false_detections",),
    ("sensor_delay", "delay"): ("sensor_delay",),
}
"""Fields of a world's effects that hold an effect's parameter."""
SENSOR_FIELDS = {("detection_range", "range"): "range", ("field_of_view", "half_angle"): "half_angle"}
CONTACT_FIELDS = {("robot_friction", "coefficient"): "robot_friction", ("wall_friction", "coefficient"): "wall_friction"}
BODY_FIELDS = {("collision_radius", "radius"): "contact_radius"}


def extend(world: WorldSpec, causes: Iterable[Cause], source: str) -> WorldSpec:
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
            key = (cause.effect, name)
            origin = _origin(number, source)
            for field in EFFECT_FIELDS.get(key, ()):
                world = world.with_effects(**{field: number.estimate})
                known[f"robot.effects.{field}"] = origin
            if key in SENSOR_FIELDS:
                world = _with_sensors(world, SENSOR_FIELDS[key], number.estimate)
                for index in range(world.num_sensors):
                    known[f"robot.sensors[{index}].{SENSOR_FIELDS[key]}"] = origin
            if key in CONTACT_FIELDS:
                world = world.replace(contact=dataclasses.replace(world.contact, **{CONTACT_FIELDS[key]: number.estimate}))
                known[f"contact.{CONTACT_FIELDS[key]}"] = origin
            if key in BODY_FIELDS:
                robots = tuple(
                    dataclasses.replace(r, body=dataclasses.replace(r.body, contact_radius=number.estimate)) for r in world.robots
                )
                world = world.replace(robots=robots)
                known[f"robot.body.{BODY_FIELDS[key]}"] = origin
    return world.replace(name=f"{world.name}_calibrated", description=f"{world.description} Calibrated from {source}.", provenance=known)


def write_extended(world: WorldSpec, causes: Iterable[Cause], source: str, path: Path) -> WorldSpec:
    """Write the extended world to a file that :func:`swarm_envs.load_world` reads; returns it."""
    extended = extend(world, causes, source)
    path.write_text(world_to_text(extended), encoding="utf-8")
    return extended


def _origin(number: Estimate, source: str) -> Provenance:
    low, high = number.ci95
    return Provenance(number.unit, f"calibrated from {source}, 95 % interval [{low:.4g}, {high:.4g}]")


def _with_radius(robot: RobotModel, radius: float) -> RobotModel:
    return dataclasses.replace(robot, body=dataclasses.replace(robot.body, contact_radius=radius))


def _with_sensors(world: WorldSpec, field: str, value: float) -> WorldSpec:
    changes: dict[str, Any] = {field: value}
    robots = tuple(
        dataclasses.replace(robot, sensors=tuple(dataclasses.replace(sensor, **changes) for sensor in robot.sensors))
        for robot in world.robots
    )
    return world.replace(robots=robots)

"""A world as the compiled code sees it: plain arrays, one row per robot, wall or object.

The column constants below are the only place that knows the layout; effects are read by name, see
:mod:`swarm_envs.simulation.effect_rows`.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from swarm_envs.simulation.effect_rows import effect_rows
from swarm_envs.simulation.segments import polygon_edges
from swarm_envs.worlds import Effects, WorldSpec
from swarm_envs.worlds.effects import ActsOn
from swarm_envs.worlds.spec import Polygon, RobotModel

FloatArray = npt.NDArray[np.float64]
T = TypeVar("T")
FeatureFlag = bool | None
"""True compiles what the flag stands for into a function; None leaves it out, and compiling takes half as long."""

# Columns of WorldArrays.robots.
(
    RADIUS,
    VISIBLE_RADIUS,
    MASS,
    STALL_HALF_ANGLE,
    WHEEL_BASE,
    SENSOR_DELAY_TICKS,
    NUM_SENSORS,
    INVERSE_MASS,
    ARM_OVER_INERTIA,  # contact radius over inertia: turn rate per tangential impulse
    TANGENT_MASS,  # kg that an impulse along the rim moves, spin included
) = ROBOT_COLUMNS = range(10)

# Columns of WorldArrays.sensors.
BEARING, COS_HALF_ANGLE, SIN_HALF_ANGLE, HALF_ANGLE, SENSOR_RANGE, PERIOD_TICKS, OCCLUSION, SEES_OBJECTS, COS_BEARING, SIN_BEARING = range(
    10
)

# Columns of WorldArrays.walls.
START_X, START_Y, ALONG_X, ALONG_Y, LENGTH = range(5)

# Entries of WorldArrays.contact.
ROBOT_FRICTION, WALL_FRICTION, ROBOT_RESTITUTION, WALL_RESTITUTION = range(4)

# Columns of WorldArrays.objects.
OBJECT_RADIUS, OBJECT_WIDTH, OBJECT_HEIGHT, OBJECT_FLOOR_FRICTION, OBJECT_OPAQUE = range(5)

MICRO_STEPS = 20
"""A tick is integrated in this many pieces when motors lag; a lattice that does not depend on the engine's substeps."""


class WorldArrays(NamedTuple):
    """Read-only parameters of one world (R robots, S sensors, E walls, B objects)."""

    tick: float
    """Seconds from one command to the next."""
    robots: FloatArray
    """(R, 10) bodies and what follows from them."""
    effects: Sequence[Effects]
    """(R,) records of each robot's effects."""
    sensors: FloatArray
    """(R, S, 10) sensor parameters."""
    contact: FloatArray
    """(4,) friction and restitution."""
    walls: FloatArray
    """(E, 5) segments: start in m, unit vector along, length in m; the free side is to the left."""
    opaque: FloatArray
    """(O, 4) segments that hide robots from sensors that mind occlusion."""
    objects: FloatArray
    """(B, 5) pushable objects."""
    ideal_drive: bool
    """No drive effect differs from neutral: the fast path."""
    ideal_sensing: bool
    """No sensing effect differs from neutral, one reading per tick, nothing hidden: the fast path."""
    reach: float
    """No robot's centre can move further than this in one tick, in m."""
    history: int
    """Commands remembered for dead time, in ticks."""
    readings: int
    """Readings remembered for the sensors' delay, in ticks."""
    broadcast_range: float
    """Largest distance in m at which robots hear a broadcast; 0 in worlds without."""


def compile_world(world: WorldSpec) -> WorldArrays:
    """Turn a spec into arrays."""
    robots = np.array(_of_each_robot(world, _robot_row))
    effects = _of_each_robot(world, _effects_in_ticks)
    models = {id(each): each for each in effects}.values()
    slots = world.num_sensors
    sensors = np.array(_of_each_robot(world, lambda robot, tick: _sensor_rows(robot, slots, tick))).reshape(len(robots), slots, 10)
    contact = np.array(dataclasses.astuple(world.contact))
    walls = [_segments(world.arena.outline, free_inside=True)]
    walls += [_segments(obstacle.outline, free_inside=False) for obstacle in world.arena.obstacles]
    opaque = [walls[0]] + [w for w, obstacle in zip(walls[1:], world.arena.obstacles, strict=True) if obstacle.opaque]
    return WorldArrays(
        tick=world.tick,
        robots=robots,
        effects=effect_rows(effects),
        sensors=sensors,
        contact=contact,
        walls=_directed(np.concatenate(walls)),
        opaque=np.ascontiguousarray(np.concatenate(opaque)),
        objects=_object_rows(world),
        ideal_drive=all(each.neutral(ActsOn.DRIVE, ActsOn.SPREAD) for each in models) and not np.any(robots[:, STALL_HALF_ANGLE]),
        ideal_sensing=all(each.neutral(ActsOn.READING) for each in models)
        and bool(np.all(sensors[:, :, PERIOD_TICKS] == 1))
        and not np.any(sensors[:, :, [OCCLUSION, SEES_OBJECTS]]),
        reach=_reach(world),
        history=2 + math.ceil(max(each.dead_time for each in models) / world.tick),
        readings=1 + int(robots[:, SENSOR_DELAY_TICKS].max()),
        broadcast_range=0.0 if world.broadcast is None else world.broadcast.range,
    )


def _of_each_robot(world: WorldSpec, of: Callable[[RobotModel, float], T]) -> list[T]:
    """Return what a function of a robot and the tick gives for each robot; it is called once for each model, of which there are few."""
    models = {id(robot): robot for robot in world.robots}
    made = {key: of(robot, world.tick) for key, robot in models.items()}
    return [made[id(robot)] for robot in world.robots]


def _effects_in_ticks(robot: RobotModel, tick: float) -> Effects:
    """A robot's effects; a reading is late by whole ticks, by none where its delay is a smaller part of one."""
    return dataclasses.replace(robot.effects, sensor_delay=tick * round(robot.effects.sensor_delay / tick))


def _robot_row(robot: RobotModel, tick: float) -> FloatArray:
    body = robot.body
    row = np.zeros(len(ROBOT_COLUMNS))
    row[RADIUS], row[VISIBLE_RADIUS], row[MASS] = body.contact_radius, body.visible_radius, body.mass
    row[STALL_HALF_ANGLE], row[WHEEL_BASE] = body.wheel_stall_half_angle, robot.drive.wheel_base
    row[SENSOR_DELAY_TICKS], row[NUM_SENSORS] = round(robot.effects.sensor_delay / tick), len(robot.sensors)
    row[INVERSE_MASS] = 1.0 / body.mass
    row[ARM_OVER_INERTIA] = 1.0 / (body.inertia_ratio * body.mass * body.contact_radius)
    row[TANGENT_MASS] = body.mass / (1.0 + 1.0 / body.inertia_ratio)
    return row


def _sensor_rows(robot: RobotModel, count: int, tick: float) -> list[list[float]]:
    rows = []
    for sensor in robot.sensors:
        bearing = sensor.bearing + robot.effects.sensor_yaw
        period = max(1, round(sensor.period / tick))
        rows.append([
            bearing, math.cos(sensor.half_angle), math.sin(sensor.half_angle), sensor.half_angle, sensor.range, period,
            float(sensor.occlusion), float(sensor.sees_objects), math.cos(bearing), math.sin(bearing),
        ])  # fmt: skip
    return rows + [[0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0]] * (count - len(rows))


def _object_rows(world: WorldSpec) -> FloatArray:
    rows = np.zeros((len(world.objects), 5))
    for row, item in zip(rows, world.objects, strict=True):
        if item.shape == "disc":
            row[OBJECT_RADIUS] = item.size[0]
        else:
            row[[OBJECT_WIDTH, OBJECT_HEIGHT]] = item.size
        row[OBJECT_FLOOR_FRICTION], row[OBJECT_OPAQUE] = item.floor_friction, float(item.opaque)
    return rows


def _segments(outline: Polygon, *, free_inside: bool) -> FloatArray:
    """Edges of a polygon, oriented so that the free side lies to the left."""
    edges = polygon_edges(outline)
    area = float(np.sum(edges[:, 0] * edges[:, 3] - edges[:, 1] * edges[:, 2]))
    return edges if (area > 0) == free_inside else polygon_edges(outline[::-1])


def _directed(segments: FloatArray) -> FloatArray:
    """Turn segments (E, 4) from start and end into start, unit vector and length (E, 5)."""
    along = segments[:, 2:] - segments[:, :2]
    length = np.hypot(along[:, 0], along[:, 1])[:, None]
    return np.ascontiguousarray(np.concatenate([segments[:, :2], along / length, length], axis=1))


def _reach(world: WorldSpec) -> float:
    """Bound on a robot's own motion in one tick, all gains and drifts at their largest (spread: five deviations)."""
    fastest = 0.0
    for robot in world.robots:
        effects = robot.effects
        gain = effects.linear_gain * (1 + 5 * effects.linear_gain_spread) * max(1.0, 1.0 - 600.0 * min(0.0, effects.gain_drift))
        drift = math.hypot(effects.floor_drift_x, effects.floor_drift_y)
        speed = world.limits.linear_speed
        if effects.deadband > 0.0:
            # with one wheel standing the robot moves at half the other's rim speed
            speed = max(speed, 0.5 * (speed + 0.5 * robot.drive.wheel_base * world.limits.angular_speed))
        fastest = max(fastest, speed * gain + drift)
    # a servo loop may overshoot a command at the limit a little
    return 1.05 * fastest * world.tick

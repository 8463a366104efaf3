"""What the binary line-of-sight sensors report.

Ideal: a sensor reports 1 when the visible disc of some other robot meets its sector and that robot's centre is within range.
The effects act in this order: occlusion, misses (constant, with distance, turning and driving), false detections, delay.
"""

from __future__ import annotations

import math

import numpy as np

from swarm_envs.compiled import compiled
from swarm_envs.simulation import parameters as p
from swarm_envs.simulation import scratch as m
from swarm_envs.simulation.grid import IntArray, bounding_box, cell_list
from swarm_envs.simulation.parameters import FeatureFlag, FloatArray, WorldArrays
from swarm_envs.simulation.randomness import STREAM_FALSE, STREAM_MISSED, uniform
from swarm_envs.simulation.scratch import Scratch
from swarm_envs.simulation.sensor_law import false_probability, meets_sector, miss_probability
from swarm_envs.simulation.state import StateArrays
from swarm_envs.simulation.trigonometry import cos_sin

NOTHING = math.inf
RAYS = 5
"""Rays over a target's width that occlusion tests; one free ray is enough to be seen."""


@compiled(inline="always", _nrt=False)
def sense(world: WorldArrays, state: StateArrays, w: int, scratch: Scratch, effects: FeatureFlag, grid: FeatureFlag) -> None:
    """Update ``state.detections`` of world ``w`` from its poses at the start of the present tick."""
    if grid is not None:
        sense_with_grid(world, state, w, effects)
    elif effects is None or world.ideal_sensing:
        sense_ideally(world, state, w, scratch.columns)
    else:
        sense_with_effects(world, state, w)


@compiled()
def sense_with_effects(world: WorldArrays, state: StateArrays, w: int) -> None:
    """Update detections of a small swarm, every effect included."""
    nobody = np.empty(0, np.int64)
    for i in range(world.sensors.shape[0]):
        read_sensors(world, state, w, i, nobody, world.sensors.shape[0])


@compiled(forceinline=True, _nrt=False)
def sense_ideally(world: WorldArrays, state: StateArrays, w: int, columns: FloatArray) -> None:
    """Update detections where no effect acts; each robot looks at all others at once, without a branch."""
    poses, robots, sensors, detections = state.poses, world.robots, world.sensors, state.detections
    count = poses.shape[1]
    for i in range(count):
        columns[m.X, i], columns[m.Y, i], columns[m.EXTENT, i] = poses[w, i, 0], poses[w, i, 1], robots[i, p.VISIBLE_RADIUS]
        columns[m.COS, i], columns[m.SIN, i] = cos_sin(poses[w, i, 2])
    for i in range(count):
        x, y, cos_heading, sin_heading = columns[m.X, i], columns[m.Y, i], columns[m.COS, i], columns[m.SIN, i]
        for s in range(int(robots[i, p.NUM_SENSORS])):
            cos_bearing, sin_bearing = sensors[i, s, p.COS_BEARING], sensors[i, s, p.SIN_BEARING]
            ax, ay = cos_heading * cos_bearing - sin_heading * sin_bearing, sin_heading * cos_bearing + cos_heading * sin_bearing
            cos_half, sin_half = sensors[i, s, p.COS_HALF_ANGLE], sensors[i, s, p.SIN_HALF_ANGLE]
            reach = sensors[i, s, p.SENSOR_RANGE]
            # the robot itself is counted, too, when it is in its own view, which depends on the sensor alone
            seen = -int(meets_sector(0.0, 0.0, cos_half, sin_half, reach, columns[m.EXTENT, i]))
            for j in range(count):
                dx, dy = columns[m.X, j] - x, columns[m.Y, j] - y
                seen += meets_sector(ax * dx + ay * dy, abs(ax * dy - ay * dx), cos_half, sin_half, reach, columns[m.EXTENT, j])
            detections[w, i, s] = seen > 0


@compiled(_nrt=False)
def nearest_seen(world: WorldArrays, state: StateArrays, w: int, i: int, s: int, candidates: IntArray, count: int) -> float:
    """Return the distance in m to the nearest robot (or object) in view of sensor ``s`` of robot ``i``, or infinity.

    Args:
        world: Parameters.
        state: State.
        w: Index of the world.
        i: Index of the robot.
        s: Index of its sensor.
        candidates: Indices of robots to look at; empty for all.
        count: Number of robots to look at.
    """
    poses = state.poses[w]
    sensor = world.sensors[i, s]
    heading = poses[i, 2] + sensor[p.BEARING]
    ax, ay = math.cos(heading), math.sin(heading)
    cos_half, sin_half, reach = sensor[p.COS_HALF_ANGLE], sensor[p.SIN_HALF_ANGLE], sensor[p.SENSOR_RANGE]
    nearest = NOTHING
    for k in range(count):
        j = candidates[k] if candidates.shape[0] > 0 else k
        if j == i:
            continue
        dx = poses[j, 0] - poses[i, 0]
        dy = poses[j, 1] - poses[i, 1]
        squared = dx * dx + dy * dy
        radius = world.robots[j, p.VISIBLE_RADIUS]
        if (
            squared < nearest * nearest
            and meets_sector(ax * dx + ay * dy, abs(ax * dy - ay * dx), cos_half, sin_half, reach, radius)
            and (
                sensor[p.OCCLUSION] == 0.0
                or in_sight(world, state, w, poses[i, 0], poses[i, 1], dx, dy, radius, ax, ay, sensor, int(np.int64(-1)))
            )
        ):
            nearest = math.sqrt(squared)
    if sensor[p.SEES_OBJECTS] != 0.0:
        for b in range(world.objects.shape[0]):
            dx = state.objects[w, b, 0] - poses[i, 0]
            dy = state.objects[w, b, 1] - poses[i, 1]
            squared = dx * dx + dy * dy
            radius = world.objects[b, p.OBJECT_RADIUS]
            if squared >= nearest * nearest:
                continue
            if radius > 0.0:
                if meets_sector(ax * dx + ay * dy, abs(ax * dy - ay * dx), cos_half, sin_half, reach, radius) and (
                    sensor[p.OCCLUSION] == 0.0 or in_sight(world, state, w, poses[i, 0], poses[i, 1], dx, dy, radius, ax, ay, sensor, b)
                ):
                    nearest = math.sqrt(squared)
            elif squared <= reach * reach and box_in_sight(world, state, w, poses[i, 0], poses[i, 1], ax, ay, sensor, b):
                nearest = math.sqrt(squared)
    return nearest


@compiled(_nrt=False)
def in_sight(
    world: WorldArrays, state: StateArrays, w: int, x: float, y: float, dx: float, dy: float, radius: float,
    ax: float, ay: float, sensor: FloatArray, target_object: int,
) -> bool:  # fmt: skip
    """Whether some ray inside the sector reaches a disc at (dx, dy) from (x, y) before anything opaque."""
    distance = math.hypot(dx, dy)
    bearing = math.atan2(ax * dy - ay * dx, ax * dx + ay * dy)
    spread = math.asin(min(1.0, radius / distance)) if distance > 0.0 else math.pi
    low = max(bearing - spread, -sensor[p.HALF_ANGLE])
    high = min(bearing + spread, sensor[p.HALF_ANGLE])
    for k in range(RAYS):
        angle = low + (high - low) * (k + 0.5) / RAYS
        ux = ax * math.cos(angle) - ay * math.sin(angle)
        uy = ay * math.cos(angle) + ax * math.sin(angle)
        ahead = ux * dx + uy * dy
        aside = ux * dy - uy * dx
        length = ahead - math.sqrt(max(0.0, radius * radius - aside * aside))
        if not blocked(world, state, w, x, y, ux, uy, length, target_object):
            return True
    return False


@compiled(_nrt=False)
def box_in_sight(
    world: WorldArrays, state: StateArrays, w: int, x: float, y: float, ax: float, ay: float, sensor: FloatArray, b: int
) -> bool:
    """Whether the box with index ``b`` meets the sector about (ax, ay) at (x, y), where occlusion counts before anything opaque.

    Seen from outside a box fills the bearings between those of two of its corners. All angles are from the sector's axis, the box's in
    one piece about its centre, which may reach past half a turn; the sector is looked for there, too.
    """
    pose = state.objects[w, b]
    half_width, half_height = 0.5 * world.objects[b, p.OBJECT_WIDTH], 0.5 * world.objects[b, p.OBJECT_HEIGHT]
    dx, dy = pose[0] - x, pose[1] - y
    c, s = math.cos(pose[2]), math.sin(pose[2])
    if abs(c * dx + s * dy) <= half_width and abs(c * dy - s * dx) <= half_height:
        return True
    centre = math.atan2(ax * dy - ay * dx, ax * dx + ay * dy)
    least = most = 0.0
    for corner in range(4):
        side, end = 1.0 - 2.0 * (corner % 2), 1.0 - 2.0 * (corner // 2)
        px = dx + c * side * half_width - s * end * half_height
        py = dy + s * side * half_width + c * end * half_height
        aside = math.atan2(dx * py - dy * px, dx * px + dy * py)
        least, most = min(least, aside), max(most, aside)
    half = sensor[p.HALF_ANGLE]
    for turns in range(-1, 2):
        low, high = max(centre + least, 2.0 * math.pi * turns - half), min(centre + most, 2.0 * math.pi * turns + half)
        if low > high:
            continue
        if sensor[p.OCCLUSION] == 0.0:
            return True
        for k in range(RAYS):
            angle = low + (high - low) * (k + 0.5) / RAYS
            ux = ax * math.cos(angle) - ay * math.sin(angle)
            uy = ay * math.cos(angle) + ax * math.sin(angle)
            if not blocked(world, state, w, x, y, ux, uy, way_to_box(dx, dy, c, s, half_width, half_height, ux, uy), b):
                return True
    return False


@compiled(_nrt=False)
def way_to_box(dx: float, dy: float, c: float, s: float, half_width: float, half_height: float, ux: float, uy: float) -> float:
    """Return how far in m it is along (ux, uy) to a box at (dx, dy) that is turned by (c, s), for a ray that meets it from outside."""
    along, across = c * ux + s * uy, c * uy - s * ux
    first, second = c * dx + s * dy, c * dy - s * dx
    enter = 0.0
    if along != 0.0:
        enter = max(enter, (first - math.copysign(half_width, along)) / along)
    if across != 0.0:
        enter = max(enter, (second - math.copysign(half_height, across)) / across)
    return enter


@compiled(_nrt=False)
def blocked(
    world: WorldArrays, state: StateArrays, w: int, x: float, y: float, ux: float, uy: float, length: float, target_object: int
) -> bool:
    """Whether something opaque lies on the ray from (x, y) along (ux, uy) nearer than ``length`` m."""
    for e in range(world.opaque.shape[0]):
        edge = world.opaque[e]
        if crosses(x, y, ux, uy, length, edge[0], edge[1], edge[2], edge[3]):
            return True
    for b in range(world.objects.shape[0]):
        if b == target_object or world.objects[b, p.OBJECT_OPAQUE] == 0.0:
            continue
        ox = state.objects[w, b, 0] - x
        oy = state.objects[w, b, 1] - y
        radius = world.objects[b, p.OBJECT_RADIUS]
        if radius > 0.0:
            ahead = ux * ox + uy * oy
            if 0.0 < ahead < length and abs(ux * oy - uy * ox) < radius:
                return True
        else:
            angle = state.objects[w, b, 2]
            cx, cy = 0.5 * world.objects[b, p.OBJECT_WIDTH], 0.5 * world.objects[b, p.OBJECT_HEIGHT]
            c, s = math.cos(angle), math.sin(angle)
            # the box's two diagonals stand for its outline: a ray through a box crosses one of them
            for sign in (1.0, -1.0):
                px, py = c * cx - s * sign * cy, s * cx + c * sign * cy
                if crosses(0.0, 0.0, ux, uy, length, ox - px, oy - py, ox + px, oy + py):
                    return True
    return False


@compiled(_nrt=False)
def crosses(x: float, y: float, ux: float, uy: float, length: float, x0: float, y0: float, x1: float, y1: float) -> bool:
    """Whether the ray of ``length`` from (x, y) along (ux, uy) crosses the segment (x0, y0)-(x1, y1)."""
    ex, ey = x1 - x0, y1 - y0
    determinant = ux * ey - uy * ex
    if determinant == 0.0:
        return False
    along = ((x0 - x) * ey - (y0 - y) * ex) / determinant
    share = ((x0 - x) * uy - (y0 - y) * ux) / determinant
    return bool(0.0 < along < length and 0.0 <= share <= 1.0)


@compiled(_nrt=False)
def read_sensors(world: WorldArrays, state: StateArrays, w: int, i: int, candidates: IntArray, count: int) -> None:
    """Take robot ``i``'s readings that are due this tick, and hand over those that its delay has let through."""
    tick = state.ticks[w]
    delay = int(world.robots[i, p.SENSOR_DELAY_TICKS])
    for s in range(int(world.robots[i, p.NUM_SENSORS])):
        ring = state.reading_history[w, i, s]
        if tick % int(world.sensors[i, s, p.PERIOD_TICKS]) == 0:
            nearest = nearest_seen(world, state, w, i, s, candidates, count)
            ring[(tick + delay) % world.readings] = np.uint8(reading(world, state, w, i, s, nearest))
        else:
            ring[(tick + delay) % world.readings] = ring[(tick + delay - 1) % world.readings]
        state.detections[w, i, s] = ring[tick % world.readings]


@compiled(_nrt=False)
def reading(world: WorldArrays, state: StateArrays, w: int, i: int, s: int, nearest: float) -> bool:
    """Return what sensor ``s`` of robot ``i`` reports for the nearest distance in m, misses and false detections included."""
    effects = world.effects[i]
    if nearest == NOTHING:
        false = false_probability(effects)
        return bool(false > 0.0 and uniform(state.keys[w], i, state.ticks[w], STREAM_FALSE + s) < false)
    share = nearest / world.sensors[i, s, p.SENSOR_RANGE]
    miss = miss_probability(effects, share, state.drive_velocity[w, i, 0], state.drive_velocity[w, i, 1])
    return bool(miss <= 0.0 or uniform(state.keys[w], i, state.ticks[w], STREAM_MISSED + s) >= miss)


@compiled()
def sense_with_grid(world: WorldArrays, state: StateArrays, w: int, effects: FeatureFlag) -> None:
    """Update detections of a large swarm: only robots in cells that the box around a robot's sectors meets are looked at."""
    poses = state.poses[w]
    count = poses.shape[0]
    low_x, low_y, width, height = bounding_box(poses)
    # about one robot per cell: a narrow beam passes through few of them
    cell = math.sqrt((width * height + 1e-6) / count)
    columns, rows = int(width / cell) + 1, int(height / cell) + 1
    first, order = cell_list(poses, low_x, low_y, cell, columns, rows)
    largest = 0.0
    for i in range(count):
        largest = max(largest, world.robots[i, p.VISIBLE_RADIUS])
    near = np.empty(count, np.int64)
    for i in range(count):
        cosine, sine = cos_sin(poses[i, 2])
        left, bottom, right, top = sectors_box(world, poses, i, cosine, sine)
        first_column = max(0, math.floor((left - largest - low_x) / cell))
        last_column = min(columns - 1, math.floor((right + largest - low_x) / cell))
        first_row = max(0, math.floor((bottom - largest - low_y) / cell))
        last_row = min(rows - 1, math.floor((top + largest - low_y) / cell))
        found = int(np.int64(0))  # a plain 0 is another type, for which callees would be compiled, too
        for r in range(first_row, last_row + 1):
            for k in range(first[r * columns + first_column], first[r * columns + last_column + 1]):
                near[found] = order[k]
                found += 1
        if effects is not None and not world.ideal_sensing:
            read_sensors(world, state, w, i, near, found)
            continue
        for s in range(int(world.robots[i, p.NUM_SENSORS])):
            sensor = world.sensors[i, s]
            ax = cosine * sensor[p.COS_BEARING] - sine * sensor[p.SIN_BEARING]
            ay = sine * sensor[p.COS_BEARING] + cosine * sensor[p.SIN_BEARING]
            cos_half, sin_half, reach = sensor[p.COS_HALF_ANGLE], sensor[p.SIN_HALF_ANGLE], sensor[p.SENSOR_RANGE]
            seen = False
            for k in range(found):
                j = near[k]
                dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
                radius = world.robots[j, p.VISIBLE_RADIUS]
                if meets_sector(ax * dx + ay * dy, abs(ax * dy - ay * dx), cos_half, sin_half, reach, radius) and j != i:
                    seen = True
                    break
            state.detections[w, i, s] = seen


@compiled(_nrt=False)
def sectors_box(world: WorldArrays, poses: FloatArray, i: int, cosine: float, sine: float) -> tuple[float, float, float, float]:
    """Return a box (left, bottom, right, top) in m that holds every sector of robot ``i``; no larger than the circle of its range.

    Args:
        world: Parameters.
        poses: (R, 3).
        i: Index of the robot.
        cosine: Of its heading.
        sine: Of its heading.
    """
    x, y = poses[i, 0], poses[i, 1]
    left, bottom, right, top = x, y, x, y
    for s in range(int(world.robots[i, p.NUM_SENSORS])):
        sensor = world.sensors[i, s]
        reach, half = sensor[p.SENSOR_RANGE], sensor[p.HALF_ANGLE]
        if half >= 0.5 * math.pi:
            left, right, bottom, top = min(left, x - reach), max(right, x + reach), min(bottom, y - reach), max(top, y + reach)
            continue
        bulge = reach * (1.0 - sensor[p.COS_HALF_ANGLE])  # the arc lies no further beyond its chord
        ax = reach * (cosine * sensor[p.COS_BEARING] - sine * sensor[p.SIN_BEARING])
        ay = reach * (sine * sensor[p.COS_BEARING] + cosine * sensor[p.SIN_BEARING])
        cos_half, sin_half = sensor[p.COS_HALF_ANGLE], sensor[p.SIN_HALF_ANGLE]
        for side in (-1.0, 1.0):
            tip_x, tip_y = x + ax * cos_half - side * ay * sin_half, y + ay * cos_half + side * ax * sin_half
            left, right = min(left, tip_x - bulge), max(right, tip_x + bulge)
            bottom, top = min(bottom, tip_y - bulge), max(top, tip_y + bulge)
    return left, bottom, right, top

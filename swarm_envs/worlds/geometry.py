"""Does a world fit together: sound outlines, room for every robot, and where robots may start."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import shapely
import shapely.affinity
from shapely.geometry import Point, Polygon, box

from swarm_envs.worlds.errors import WorldError
from swarm_envs.worlds.spec import PushableObject, WorldSpec

CLEARANCE = 1e-3
"""Gap in m kept between robots, walls and objects at the start."""


def check_world_geometry(world: WorldSpec) -> None:
    """Refuse a world whose polygons are unsound, whose limits exceed the robots', or whose robots do not fit.

    Raises:
        WorldError: One line with the world's name, the key and the reason.
    """
    _polygon(world.arena.outline, f"{world.name}: arena.outline")
    outer = Polygon(world.arena.outline)
    for index, obstacle in enumerate(world.arena.obstacles):
        where = f"{world.name}: arena.obstacles[{index}].outline"
        if not outer.intersects(_polygon(obstacle.outline, where)):
            raise WorldError(f"{where}: lies outside the arena; move it inside or remove it")
    for index, item in enumerate(world.objects):
        where = f"{world.name}: objects[{index}]"
        if item.shape not in ("disc", "box"):
            raise WorldError(f"{where}.shape: given {item.shape!r}, expected 'disc' or 'box'")
        if len(item.pose) != 3 or not all(isinstance(number, float) for number in (*item.pose, *item.size)):
            raise WorldError(f"{where}: given pose {list(item.pose)} and size {list(item.size)}, expected [x, y, angle] and plain numbers")
        if len(item.size) != {"disc": 1, "box": 2}[item.shape]:
            raise WorldError(f"{where}.size: given {list(item.size)}, expected [radius] of a disc or [width, height] of a box")
        if not outer.contains(object_footprint(item)):
            raise WorldError(f"{where}.pose: the object does not lie inside the arena; move it")
        others = [Polygon(obstacle.outline) for obstacle in world.arena.obstacles] + [object_footprint(o) for o in world.objects[:index]]
        if any(object_footprint(item).intersection(other).area > 1e-9 for other in others):
            raise WorldError(f"{where}.pose: the object overlaps an obstacle or another object; move it")
    _check_limit(world, "linear_speed", world.limits.linear_speed, min(r.drive.max_linear_speed for r in world.robots), "m/s")
    _check_limit(world, "angular_speed", world.limits.angular_speed, min(r.drive.max_angular_speed for r in world.robots), "rad/s")
    start_points(world)


def start_points(world: WorldSpec) -> npt.NDArray[np.float64]:
    """Return the points (points, 2) in m on which robots may start; at least as many as robots.

    The world's own grid where it has room for every robot, else the widest square lattice that has.

    Raises:
        WorldError: When no lattice has room for every robot.
    """
    radius = max(robot.body.contact_radius for robot in world.robots)
    free = free_floor(world, radius + CLEARANCE)
    shapely.prepare(free)
    start = world.start
    centre = _centre(world)
    columns, rows = round(start.columns), round(start.rows)
    needed, closest = world.num_robots, 2 * radius + CLEARANCE
    if min(start.spacing_x, start.spacing_y) >= closest:
        grid = _inside(free, _lattice(centre, columns, rows, start.spacing_x, start.spacing_y))
        if len(grid) >= needed:
            return grid
    width, height = world.size
    spacing = max(closest, math.sqrt(width * height / needed))
    while True:
        columns, rows = math.ceil(width / spacing), math.ceil(height / spacing)
        grid = _inside(free, _lattice(centre, columns, rows, spacing, spacing))
        if len(grid) >= needed:
            return grid
        if spacing <= closest:
            raise WorldError(
                f"{world.name}: num_robots: {needed} robots of radius {radius:g} m do not fit, a lattice has room for {len(grid)}; "
                "take fewer robots or a larger arena"
            )
        spacing = max(closest, spacing * 0.98)


def free_floor(world: WorldSpec, margin: float) -> shapely.Geometry:
    """Where the centre of a disc of radius ``margin`` m may be at the start: clear of walls, obstacles and objects."""
    floor = Polygon(world.arena.outline).buffer(-margin, quad_segs=32)
    taken = [Polygon(obstacle.outline) for obstacle in world.arena.obstacles] + [object_footprint(item) for item in world.objects]
    return shapely.difference(floor, shapely.union_all([shape.buffer(margin, quad_segs=32) for shape in taken]))


def object_footprint(item: PushableObject) -> Polygon:
    """The floor that a pushable object covers at its start, in m."""
    x, y, angle = item.pose
    if item.shape == "disc":
        return Point(x, y).buffer(item.size[0], quad_segs=32)
    width, height = item.size
    shape = shapely.affinity.rotate(box(-width / 2, -height / 2, width / 2, height / 2), angle, origin=(0, 0), use_radians=True)
    return shapely.affinity.translate(shape, x, y)


def _check_limit(world: WorldSpec, name: str, given: float, physical: float, unit: str) -> None:
    if given > physical:
        raise WorldError(
            f"{world.name}: limits.{name}: given {given:g}, expected at most what its slowest robot can do, {physical:g} {unit}"
        )


def _centre(world: WorldSpec) -> tuple[float, float]:
    xs, ys = zip(*world.arena.outline, strict=True)
    return (min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2


def _lattice(centre: tuple[float, float], columns: int, rows: int, dx: float, dy: float) -> npt.NDArray[np.float64]:
    """A centred grid of points, row by row from the lower left."""
    xs = centre[0] + dx * (np.arange(columns) - (columns - 1) / 2)
    ys = centre[1] + dy * (np.arange(rows) - (rows - 1) / 2)
    grid = np.stack(np.meshgrid(xs, ys), axis=-1)
    return np.asarray(grid.reshape(-1, 2), dtype=np.float64)


def _inside(free: shapely.Geometry, points: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    return np.ascontiguousarray(points[shapely.contains_xy(free, points)])


def _polygon(outline: tuple[tuple[float, float], ...], where: str) -> Polygon:
    for index, point in enumerate(outline):
        if not isinstance(point, tuple) or len(point) != 2 or not all(isinstance(number, float) for number in point):
            raise WorldError(f"{where}[{index}]: expected a point [x, y] of two numbers in m")
    if len(outline) < 3:
        raise WorldError(f"{where}: given {len(outline)} entries, expected at least 3 points [x, y]")
    for index, point in enumerate(outline):
        if math.dist(point, outline[index - 1]) < 1e-9:
            raise WorldError(f"{where}: corner {index} at {list(point)} repeats the one before; list each corner once")
    shape = Polygon(outline)
    if not shape.is_valid or shape.area <= 0 or not all(math.isfinite(c) for point in outline for c in point):
        reason = shapely.is_valid_reason(shape)
        raise WorldError(f"{where}: not a simple polygon ({reason}); list finite corners in order, without crossing")
    return shape

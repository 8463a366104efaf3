"""Numbers that say what a swarm does, from its trajectories.

Every function takes trajectories with ``poses`` (worlds, frames, robots, 3) in m, m, rad, ``time`` (frames,) in s and ``world``, and
returns one number per world, (worlds,), unless it says otherwise. Averages run over the last ``steps`` ticks of the run (100 in the paper,
10 s); when fewer are recorded, over all. Where only every n-th tick is recorded the same time span is taken from fewer frames.

Symbols: p_i position of robot i, c = mean p_i the swarm's centroid, v_i = (p_i - p_i before) / dt its velocity by backward difference
between recorded frames, a x b = a_x b_y - a_y b_x, r = sqrt(w^2 + h^2) / 2 with w and h the sides of the arena's bounding box; mean_i over
robots, and the mean over frames where nothing else is said.
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np
import numpy.typing as npt
import shapely

from swarm_envs.compiled import compiled
from swarm_envs.deprecation import forwarding
from swarm_envs.simulation.contacts import WALL_CONTACT, contact_flags
from swarm_envs.simulation.segments import wall_segments
from swarm_envs.worlds.spec import WorldSpec

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

CONTACT_GAP = 1.5e-3
"""Gap in m up to which two robots, or a robot and a wall, are said to touch; the simulation's overlap bound is of this size."""


class PoseTrajectories(Protocol):
    """What metrics need of :class:`swarm_envs.Trajectories`."""

    @property
    def poses(self) -> Array:
        """(worlds, frames, robots, 3) in m, m, rad."""

    @property
    def time(self) -> Array:
        """(frames,) in s."""

    @property
    def world(self) -> WorldSpec:
        """The world that all runs happened in."""


def hand_crafted(trajectories: PoseTrajectories, steps: int = 100) -> Array:
    """Return the five hand-crafted measures of the paper's baseline (Brown et al. 2018), (worlds, 5).

    In this order: :func:`average_speed`, :func:`angular_momentum`, :func:`radial_variance`, :func:`scatter`, :func:`group_rotation`.
    """
    measures = (average_speed, angular_momentum, radial_variance, scatter, group_rotation)
    return np.stack([measure(trajectories, steps) for measure in measures], axis=1)


def average_speed(trajectories: PoseTrajectories, steps: int = 100) -> Array:
    """Mean_i |v_i| in m/s.

    Example:
        >>> import swarm_envs
        >>> runs = swarm_envs.rollouts("hero_plus", [[0.05, 0, 0.05, 0]], robots=1, initial_poses=[[[0.3, 0.7, 0.0]]], steps=150)
        >>> average_speed(runs).round(6).tolist()
        [0.05]
    """
    return np.asarray(np.hypot(*_final_motion(trajectories, steps).velocity).mean(axis=(1, 2)))


def angular_momentum(trajectories: PoseTrajectories, steps: int = 100) -> Array:
    """Mean_i v_i x (p_i - c) / r in m/s; negative when the swarm turns counter-clockwise."""
    part = _final_motion(trajectories, steps)
    return np.asarray(_cross(part.velocity, part.arm).mean(axis=(1, 2)) / world_radius(trajectories.world))


def radial_variance(trajectories: PoseTrajectories, steps: int = 100) -> Array:
    """Var_i |p_i - c| / (0.15 r^2), without unit; 0 on a circle. The variance is that of the population (divided by its number)."""
    part = _final_motion(trajectories, steps)
    return np.asarray(np.hypot(*part.arm).var(axis=2).mean(axis=1) / (0.15 * world_radius(trajectories.world) ** 2))


def scatter(trajectories: PoseTrajectories, steps: int = 100) -> Array:
    """Mean_i |p_i - c|^2 / r^2, without unit."""
    part = _final_motion(trajectories, steps)
    return np.asarray((part.arm[0] ** 2 + part.arm[1] ** 2).mean(axis=(1, 2)) / world_radius(trajectories.world) ** 2)


def group_rotation(trajectories: PoseTrajectories, steps: int = 100) -> Array:
    """Mean_i v_i x (p_i - c) / |p_i - c| in m/s; negative counter-clockwise. A robot on the centroid counts as zero."""
    part = _final_motion(trajectories, steps)
    distance = np.hypot(*part.arm)
    return np.asarray((_cross(part.velocity, part.arm) / np.where(distance > 0, distance, 1.0)).mean(axis=(1, 2)))


def polarization(trajectories: PoseTrajectories, steps: int = 100) -> Array:
    """|Mean_i (cos theta_i, sin theta_i)|, from 0 (headings cancel) to 1 (all alike)."""
    heading = _final_poses(trajectories, steps)[..., 2]
    return np.asarray(np.hypot(np.cos(heading).mean(axis=2), np.sin(heading).mean(axis=2)).mean(axis=1))


def convex_hull_area(trajectories: PoseTrajectories, steps: int = 100) -> Array:
    """Area of the convex hull of the robots' centres in m^2."""
    positions = _final_poses(trajectories, steps)[..., :2]
    worlds, frames, robots = positions.shape[:3]
    swarms = shapely.multipoints(positions.reshape(-1, 2), indices=np.repeat(np.arange(worlds * frames), robots))
    return np.asarray(shapely.area(shapely.convex_hull(swarms)).reshape(worlds, frames).mean(axis=1))


def nearest_neighbour_distance(trajectories: PoseTrajectories, steps: int = 100) -> Array:
    """Mean_i of the distance to the nearest other robot's centre in m; infinite for a lone robot."""
    return np.asarray(nearest_distances(_final_poses(trajectories, steps)).mean(axis=(1, 2)))


def collisions(trajectories: PoseTrajectories, steps: int = 100) -> Array:
    """Share of robots that touch a robot, a wall or an obstacle, from 0 to 1; gaps up to ``CONTACT_GAP`` count as touching."""
    return np.asarray(in_contact(trajectories.world, _final_poses(trajectories, steps)).mean(axis=(1, 2)))


def coverage(trajectories: PoseTrajectories, steps: int | None = None) -> Array:
    """Share of the arena that some robot's contact disc swept, from 0 to 1; over the whole run unless ``steps`` are given.

    Measured on a lattice of floor points as far apart as a quarter of the smallest contact radius; a point is swept when it lies in a
    contact disc in some recorded frame.
    """
    world = trajectories.world
    poses = trajectories.poses if steps is None else _final_poses(trajectories, steps)
    radii = contact_radii(world)
    lattice = _FloorGrid(world, max(radii.min() / 4, math.sqrt(world.size[0] * world.size[1] / 1e6)))
    return np.asarray(_swept(np.ascontiguousarray(poses), radii, lattice.on_floor, lattice.frame))


def in_contact(world: WorldSpec, poses: npt.ArrayLike) -> Flags:
    """Say which robots touch another robot, a wall or an obstacle.

    Args:
        world: The world.
        poses: (..., robots, 2 or more) in m.

    Returns:
        (..., robots) bool.
    """
    return _contacts(world, poses) > 0


def at_wall(world: WorldSpec, poses: npt.ArrayLike) -> Flags:
    """Say which robots touch a wall or an obstacle; arguments and result as :func:`in_contact`."""
    return _contacts(world, poses) & WALL_CONTACT > 0


def nearest_distances(positions: npt.ArrayLike) -> Array:
    """Distance in m from each robot's centre to the nearest other's, (..., robots) of positions (..., robots, 2 or more).

    Example:
        >>> nearest_distances([[0, 0], [3, 4], [3, 0]]).tolist()
        [3.0, 4.0, 3.0]
    """
    where = np.asarray(positions, dtype=np.float64)
    flat = np.ascontiguousarray(where[..., :2]).reshape(-1, where.shape[-2], 2)
    return np.asarray(_nearest(flat).reshape(where.shape[:-1]))


def world_radius(world: WorldSpec) -> float:
    """Half the diagonal of the arena's bounding box in m: the r of the formulas.

    Example:
        >>> import swarm_envs
        >>> round(world_radius(swarm_envs.load_world("hero_plus")), 4)
        1.1075
    """
    return math.hypot(*world.size) / 2


def contact_radii(world: WorldSpec) -> Array:
    """Contact radius of each robot, (robots,) in m."""
    return np.array([robot.body.contact_radius for robot in world.robots], dtype=np.float64)


def floor_shape(world: WorldSpec, margin: float = 0.0) -> shapely.Geometry:
    """The arena without its obstacles, less a margin in m along every wall."""
    floor = shapely.buffer(shapely.Polygon(world.arena.outline), -margin)
    obstacles = [shapely.buffer(shapely.Polygon(obstacle.outline), margin) for obstacle in world.arena.obstacles]
    return shapely.difference(floor, shapely.union_all(obstacles))


def floor_points(world: WorldSpec, spacing: float) -> Array:
    """Points (n, 2) in m of a square lattice that lie on the floor, each for about ``spacing`` squared of it."""
    lattice = _FloorGrid(world, spacing)
    return lattice.points[lattice.on_floor]


class _FloorGrid:
    """Points about ``spacing`` m apart over the arena's bounding box, the middles of equal rectangles.

    Attributes:
        points: (rows, columns, 2) in m.
        on_floor: (rows, columns), which lie in the arena and in no obstacle.
        frame: (4,) left and bottom of the box and the rectangles' width and height in m.
    """

    def __init__(self, world: WorldSpec, spacing: float) -> None:
        (left, bottom), (width, height) = np.min(world.arena.outline, axis=0), world.size
        columns, rows = max(1, round(width / spacing)), max(1, round(height / spacing))
        xs, ys = left + width * (np.arange(columns) + 0.5) / columns, bottom + height * (np.arange(rows) + 0.5) / rows
        self.points: Array = np.stack(np.meshgrid(xs, ys), axis=-1)
        self.on_floor: Flags = shapely.contains_xy(floor_shape(world), self.points[..., 0], self.points[..., 1])
        self.frame: Array = np.array([left, bottom, width / columns, height / rows])


class _FinalMotion:
    """The last part of all runs: ``velocity`` and ``arm`` = p - c, each (2, worlds, frames, robots)."""

    def __init__(self, poses: Array, time: Array) -> None:
        position = np.moveaxis(poses[..., :2], -1, 0)
        self.arm = position[:, :, 1:] - position[:, :, 1:].mean(axis=-1, keepdims=True)
        self.velocity = np.diff(position, axis=2) / np.diff(time)[:, None]


def _final_motion(trajectories: PoseTrajectories, steps: int) -> _FinalMotion:
    """The last steps: positions at their ends, velocities over them."""
    first = _first_frame(trajectories, steps)
    return _FinalMotion(trajectories.poses[:, first:], np.asarray(trajectories.time)[first:])


def _final_poses(trajectories: PoseTrajectories, steps: int) -> Array:
    """Poses at the ends of the last steps, (worlds, frames, robots, 3)."""
    return trajectories.poses[:, _first_frame(trajectories, steps) + 1 :]


def _first_frame(trajectories: PoseTrajectories, steps: int) -> int:
    """The recorded frame that the last ``steps`` ticks start from."""
    time = np.asarray(trajectories.time)
    if len(time) < 2:
        raise ValueError(f"the trajectories hold {len(time)} frame(s), expected at least 2: a metric needs a step to look at")
    tick = trajectories.world.tick
    return int(min(np.searchsorted(time, time[-1] - (steps + 0.5) * tick), len(time) - 2))


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[0] * b[1] - a[1] * b[0])


def _contacts(world: WorldSpec, poses: npt.ArrayLike) -> npt.NDArray[np.uint8]:
    where = np.asarray(poses, dtype=np.float64)
    flat = np.ascontiguousarray(where[..., :2]).reshape(-1, where.shape[-2], 2)
    return np.asarray(contact_flags(flat, contact_radii(world), wall_segments(world), CONTACT_GAP).reshape(where.shape[:-1]))


@compiled()
def _nearest(positions: Array) -> Array:
    """Distance to the nearest other robot, (moments, robots) of positions (moments, robots, 2)."""
    moments, robots = positions.shape[:2]
    out = np.full((moments, robots), np.inf)
    for moment in range(moments):
        at, best = positions[moment], out[moment]
        for i in range(robots):
            for j in range(i):
                distance = math.hypot(at[i, 0] - at[j, 0], at[i, 1] - at[j, 1])
                best[i], best[j] = min(best[i], distance), min(best[j], distance)
    return out


@compiled()
def _swept(poses: Array, radii: Array, floor: Flags, lattice: Array) -> Array:
    """Share of the floor's lattice points that lay in a disc in some frame, (worlds,)."""
    worlds, frames, robots = poses.shape[:3]
    rows, columns = floor.shape
    out = np.empty(worlds)
    for world in range(worlds):
        swept = np.zeros((rows, columns), dtype=np.bool_)
        for frame, robot in np.ndindex(frames, robots):
            x, y = (poses[world, frame, robot, 0] - lattice[0]) / lattice[2], (poses[world, frame, robot, 1] - lattice[1]) / lattice[3]
            reach_x, reach_y = radii[robot] / lattice[2], radii[robot] / lattice[3]
            if not (-reach_x < x < columns + reach_x and -reach_y < y < rows + reach_y):
                continue
            for row in range(max(0, math.floor(y - reach_y)), min(rows, math.floor(y + reach_y) + 1)):
                for column in range(max(0, math.floor(x - reach_x)), min(columns, math.floor(x + reach_x) + 1)):
                    if ((column + 0.5 - x) / reach_x) ** 2 + ((row + 0.5 - y) / reach_y) ** 2 <= 1:
                        swept[row, column] = floor[row, column]
        out[world] = swept.sum() / floor.sum()
    return out


__getattr__ = forwarding(
    __name__,
    {"Trajectories": "swarm_envs.metrics.PoseTrajectories"}
    | {name: f"swarm_envs.simulation.segments.{name}" for name in ("polygon_edges", "segment_distance")},
)

"""The colour picture of one moment: ``rgb_array`` without display or GPU."""

from __future__ import annotations

import functools
import math

import numpy as np
import numpy.typing as npt

from swarm_envs.compiled import compiled
from swarm_envs.rendering import palette, raster
from swarm_envs.rendering.view import background, view_of
from swarm_envs.worlds.spec import WorldSpec

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
Picture = npt.NDArray[np.uint8]

TRAIL_WIDTH = 0.008
"""Width of a trail in m, never less than a pixel."""
TRAIL_ALPHA = 0.55
"""Opacity of a trail at the robot; it falls to zero at its old end."""


class Renderer:
    """Draws pictures of one world; make it once, call it for each frame.

    Each robot is its contact disc (the bump shield), pale, its visible disc (the body) in the robot's own colour, and a dark mark from the
    centre to the contact disc's edge along the heading. Robot ``i`` has the same colour in every picture.

    Args:
        world: The world; its outline may be concave and lie anywhere.
        width: Picture width in pixels.
        height: Picture height in pixels; by default what the arena needs at that width (426 for the paper's arena at 513), see
            :func:`swarm_envs.rendering.view.view_of`.

    Attributes:
        shape: (height, width, 3) of the pictures.
        view: From metres to pixels.
    """

    def __init__(self, world: WorldSpec, width: int = 513, height: int | None = None) -> None:
        self.world = world
        self.view = view_of(world, width, height)
        self.shape = (self.view.height, self.view.width, 3)
        self._background = background(world, self.view)
        self._colours = palette.robot_colours(world.num_robots)
        scale = self.view.scale
        self._contact = np.array([robot.body.contact_radius for robot in world.robots]) * scale
        self._visible = np.array([robot.body.visible_radius for robot in world.robots]) * scale
        self._sensors = _sensors(world) * np.array([1.0, 1.0, 1.0, scale])
        self._trail_width = max(1.0, TRAIL_WIDTH * scale)

    def __call__(
        self,
        poses: npt.ArrayLike,
        detections: npt.ArrayLike | None = None,
        trail: npt.ArrayLike | None = None,
        contacts: npt.ArrayLike | None = None,
        object_poses: npt.ArrayLike | None = None,
    ) -> Picture:
        """Draw one moment; see :func:`render` for the arguments."""
        robots = len(self._contact)
        where = _checked(poses, "poses", (robots, 3))
        canvas = self._background.copy()
        if trail is not None:
            path = np.asarray(trail, dtype=np.float64)
            if path.ndim != 3 or path.shape[1] != robots or path.shape[2] < 2:
                raise ValueError(f"trail has shape {path.shape}, expected (points, {robots}, 2 or 3)")
            _draw_trails(canvas, self.view.pixels(path), self._colours, self._trail_width, TRAIL_ALPHA)
        at = np.concatenate([self.view.pixels(where), where[:, 2:]], axis=1)
        if detections is not None:
            _draw_beams(canvas, at, self._sensors, self._seen(detections), self._colours, _BEAM)
        self._draw_objects(canvas, object_poses)
        touching = np.zeros(robots, dtype=np.bool_) if contacts is None else _checked(contacts, "contacts", (robots,)).astype(np.bool_)
        _draw_robots(canvas, at, self._contact, self._visible, touching, self._colours, _INK, _FLASH)
        return canvas

    def _seen(self, detections: npt.ArrayLike) -> Flags:
        """One flag per sensor of ``self._sensors``."""
        flags = np.asarray(detections).astype(np.bool_)
        flags = flags.reshape(len(flags), -1) if flags.ndim else flags
        if flags.shape == (len(self._contact), self.world.num_readings):
            flags = flags[:, : self.world.num_sensors]  # what a robot hears is no beam
        needed = (len(self._contact), self.world.num_sensors)
        if flags.shape != needed:
            raise ValueError(f"detections have shape {np.shape(detections)}, expected {needed[:1] if needed[1] == 1 else needed}")
        return np.ascontiguousarray(flags[self._sensors[:, 0].astype(np.intp), _sensor_numbers(self.world)])

    def _draw_objects(self, canvas: Picture, object_poses: npt.ArrayLike | None) -> None:
        objects = self.world.objects
        poses = [item.pose for item in objects] if object_poses is None else object_poses
        if not objects:
            return
        where = _checked(poses, "object_poses", (len(objects), 3))
        scale, edge = self.view.scale, max(1.0, 0.004 * self.view.scale)
        for item, (x, y), angle in zip(objects, self.view.pixels(where), where[:, 2], strict=True):
            if item.shape == "disc":
                raster.annulus(canvas, x, y, -1.0, item.size[0] * scale, _INK, 1.0)
                raster.annulus(canvas, x, y, -1.0, item.size[0] * scale - edge, _OBJECT, 1.0)
            else:
                half_x, half_y = (side * scale / 2 for side in item.size)
                raster.box(canvas, x, y, angle, half_x, half_y, edge, _INK, 1.0)
                raster.box(canvas, x, y, angle, half_x - edge, half_y - edge, 0.0, _OBJECT, 1.0)


def render(
    world: WorldSpec,
    poses: npt.ArrayLike,
    detections: npt.ArrayLike | None = None,
    trail: npt.ArrayLike | None = None,
    contacts: npt.ArrayLike | None = None,
    object_poses: npt.ArrayLike | None = None,
    width: int = 513,
) -> Picture:
    """Draw one moment of a world.

    Args:
        world: The world.
        poses: (robots, 3) in m, m, rad. A robot whose pose is not finite is not drawn.
        detections: (robots,), or (robots, sensors) where a robot has several: draws each sensor's beam, highlighted where it is true.
        trail: (points, robots, 2 or 3) in m: earlier poses, oldest first; fades towards the oldest.
        contacts: (robots,): robots that touch something flash.
        object_poses: (objects, 3) in m, m, rad; by default where the world puts its pushable objects.
        width: Picture width in pixels.

    Returns:
        (height, width, 3) uint8, y up in the arena is up in the picture; 426 x 513 for the paper's arena.

    Raises:
        ValueError: When an array's shape does not fit the world.
    """
    return _renderer(world, width)(poses, detections, trail, contacts, object_poses)


@functools.lru_cache(maxsize=8)
def _renderer(world: WorldSpec, width: int) -> Renderer:
    return Renderer(world, width)


def _checked(values: npt.ArrayLike, name: str, shape: tuple[int, ...]) -> Array:
    array = np.asarray(values, dtype=np.float64)
    if array.shape != shape:
        raise ValueError(f"{name} have shape {array.shape}, expected {shape}")
    return array


def _sensors(world: WorldSpec) -> Array:
    """List every sensor of every robot: (sensors, 4) robot, direction from the heading in rad, half-angle in rad, range in m."""
    rows = [
        (float(index), sensor.bearing + robot.effects.sensor_yaw, sensor.half_angle, sensor.range)
        for index, robot in enumerate(world.robots)
        for sensor in robot.sensors
    ]
    return np.array(rows, dtype=np.float64).reshape(-1, 4)


@functools.lru_cache(maxsize=8)
def _sensor_numbers(world: WorldSpec) -> npt.NDArray[np.intp]:
    """Number of each listed sensor on its own robot."""
    return np.array([slot for robot in world.robots for slot in range(len(robot.sensors))], dtype=np.intp)


def _pixel(colour: palette.Colour) -> Picture:
    return np.array(colour, dtype=np.uint8)


_INK, _FLASH, _OBJECT, _BEAM = _pixel(palette.INK), _pixel(palette.FLASH), _pixel(palette.OBJECT), _pixel(palette.BEAM)


@compiled()
def _draw_trails(canvas: Picture, path: Array, colours: Picture, width: float, alpha: float) -> None:
    points, robots = path.shape[0], path.shape[1]
    for robot in range(robots):
        for k in range(points - 1):
            x0, y0, x1, y1 = path[k, robot, 0], path[k, robot, 1], path[k + 1, robot, 0], path[k + 1, robot, 1]
            raster.stroke(canvas, x0, y0, x1, y1, width, colours[robot], alpha * (k + 1) / points)


@compiled()
def _draw_beams(canvas: Picture, at: Array, sensors: Array, seen: Flags, colours: Picture, idle: Picture) -> None:
    for k in range(sensors.shape[0]):
        robot = int(sensors[k, 0])
        x, y, angle = at[robot, 0], at[robot, 1], at[robot, 2] + sensors[k, 1]
        if seen[k]:
            raster.sector(canvas, x, y, angle, sensors[k, 2], sensors[k, 3], colours[robot], 0.50, 0.18)
        else:
            raster.sector(canvas, x, y, angle, sensors[k, 2], sensors[k, 3], idle, 0.20, 0.02)


@compiled()
def _draw_robots(
    canvas: Picture, at: Array, contact: Array, visible: Array, touching: Flags, colours: Picture, ink: Picture, flash: Picture
) -> None:
    for robot in range(at.shape[0]):
        x, y, angle = at[robot, 0], at[robot, 1], at[robot, 2]
        if not math.isfinite(x + y + angle):
            continue
        outer, body, colour = contact[robot], visible[robot], colours[robot]
        line = max(0.8, 0.06 * outer)
        raster.annulus(canvas, x, y, -1.0, outer, colour, 0.30)
        if touching[robot]:
            raster.annulus(canvas, x, y, outer - 2.5 * line, outer, flash, 0.95)
        else:
            raster.annulus(canvas, x, y, outer - line, outer, colour, 0.80)
        raster.annulus(canvas, x, y, -1.0, body, colour, 1.0)
        half = 0.5 * outer
        raster.box(canvas, x + half * math.cos(angle), y - half * math.sin(angle), angle, half, 0.11 * outer, 0.11 * outer, ink, 1.0)

"""What a world is: immutable dataclasses in SI units, built from a YAML file by :mod:`swarm_envs.worlds.load`.

Angles are counter-clockwise, x points right, y up; the arena frame has its origin at the inner lower left corner of the arena.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Self

from swarm_envs.worlds.effects import Effects
from swarm_envs.worlds.errors import WorldError
from swarm_envs.worlds.quantity import Provenance, quantity

Point = tuple[float, float]
Polygon = tuple[Point, ...]


@dataclass(frozen=True)
class Body:
    """The robot as contact and other robots' sensors know it: two concentric discs."""

    contact_radius: float = quantity("m", low=1e-4, high=10.0)
    """Radius of the disc that touches walls and robots (the bump shield, where there is one)."""
    visible_radius: float = quantity("m", low=1e-4, high=10.0)
    """Radius of the disc that other robots' sensors see (the body)."""
    mass: float = quantity("kg", 0.140, low=1e-6, high=1000.0)
    """Mass."""
    inertia_ratio: float = quantity("1", 0.5, low=1e-3, high=10.0)
    """Moment of inertia about the vertical axis over mass x contact_radius squared; 1/2 is a uniform disc."""
    wheel_stall_half_angle: float = quantity("rad", 0.0, low=0.0, high=math.pi / 2)
    """A robot touched by another within this angle of a wheel's axle stands still while touched; 0 when a shield keeps wheels free."""


@dataclass(frozen=True)
class Drive:
    """The differential drive."""

    wheel_base: float = quantity("m", low=1e-4, high=10.0)
    """Distance between the wheels' contact points."""
    max_linear_speed: float = quantity("m/s", low=0.0, high=100.0)
    """Physical limit of the forward speed."""
    max_angular_speed: float = quantity("rad/s", low=0.0, high=1000.0)
    """Physical limit of the turn rate."""


@dataclass(frozen=True)
class Sensor:
    """A binary line-of-sight sensor at the robot's centre: does any robot's visible disc meet its sector?"""

    half_angle: float = quantity("rad", low=0.0, high=math.pi)
    """Half the opening angle of the sector."""
    range: float = quantity("m", low=0.0, high=1000.0)
    """Greatest distance to the centre of a robot that is seen."""
    bearing: float = quantity("rad", 0.0, low=-math.pi, high=math.pi)
    """Direction of the sector's axis from the heading, counter-clockwise."""
    period: float = quantity("s", 0.1, low=1e-3, high=100.0)
    """Time from one reading to the next (rounded to whole ticks)."""
    occlusion: bool = False
    """Whether opaque obstacles, opaque objects and reflex corners of the arena hide robots."""
    sees_objects: bool = False
    """Whether pushable objects are reported like robots: when their outline meets the sector and their centre is in range."""


@dataclass(frozen=True)
class RobotModel:
    """One kind of robot: the part of a robot file that worlds use, and its effects."""

    name: str
    body: Body
    drive: Drive
    sensors: tuple[Sensor, ...]
    effects: Effects = field(default_factory=Effects)


@dataclass(frozen=True)
class Limits:
    """What a controller may ask for in this world; the boxes of the action space."""

    linear_speed: float = quantity("m/s", low=0.0, high=100.0)
    """Commands have abs(v) at most this."""
    angular_speed: float = quantity("rad/s", low=0.0, high=1000.0)
    """Commands have abs(omega) at most this."""


@dataclass(frozen=True)
class Contact:
    """The one contact law's coefficients: Coulomb friction and Newton restitution.

    A robot's drive asks for its desired velocity again each tick, so restitution throws it back for the rest of a tick at most; objects
    keep their bounce.
    """

    robot_friction: float = quantity("1", 0.0, low=0.0, high=10.0)
    """Coulomb coefficient robot against robot or object."""
    wall_friction: float = quantity("1", 0.0, low=0.0, high=10.0)
    """Coulomb coefficient robot against wall or obstacle."""
    robot_restitution: float = quantity("1", 0.0, low=0.0, high=1.0)
    """Restitution robot against robot or object."""
    wall_restitution: float = quantity("1", 0.0, low=0.0, high=1.0)
    """Restitution robot against wall or obstacle."""


@dataclass(frozen=True)
class Obstacle:
    """An immovable polygon inside the arena."""

    outline: Polygon = quantity("m")
    """Corners in the arena frame, in order; convex or concave, not crossing itself."""
    opaque: bool = True
    """Whether it hides robots from sensors that mind occlusion."""


@dataclass(frozen=True)
class PushableObject:
    """A disc or box that robots push; it slides on the floor with Coulomb friction."""

    shape: str
    """``disc`` or ``box``."""
    size: tuple[float, ...] = quantity("m", low=1e-4, high=100.0)
    """Radius of a disc as ``[r]``, width and height of a box as ``[w, h]``."""
    pose: tuple[float, float, float] = quantity("1", (0.0, 0.0, 0.0))
    """Start: x in m, y in m, angle in rad."""
    mass: float = quantity("kg", 0.05, low=1e-6, high=1000.0)
    """Mass."""
    floor_friction: float = quantity("1", 0.3, low=0.0, high=10.0)
    """Coulomb coefficient against the floor."""
    opaque: bool = True
    """Whether it hides robots from sensors that mind occlusion."""


@dataclass(frozen=True)
class Arena:
    """Where robots live."""

    outline: Polygon = quantity("m")
    """Inner edge of the walls, corners in order; convex or concave."""
    obstacles: tuple[Obstacle, ...] = ()
    """Immovable polygons inside."""
    picture_border: float = quantity("m", 0.0, low=0.0, high=10.0)
    """Margin drawn around the arena in a picture."""


@dataclass(frozen=True)
class Start:
    """Robots start on distinct points of a centred grid, headings uniform on the circle."""

    columns: float = quantity("1", 4.0, low=1, high=1000)
    """Grid points along x."""
    rows: float = quantity("1", 3.0, low=1, high=1000)
    """Grid points along y."""
    spacing_x: float = quantity("m", 0.3025, low=1e-3, high=100.0)
    """Distance of neighbouring points along x."""
    spacing_y: float = quantity("m", 0.27, low=1e-3, high=100.0)
    """Distance of neighbouring points along y."""


@dataclass(frozen=True)
class Broadcast:
    """A channel of one bit: a robot that sends is heard by every robot in range, at the end of the tick in which it sends."""

    range: float = quantity("m", low=1e-3, high=1000.0)
    """Largest distance from centre to centre at which a robot hears another."""


@dataclass(frozen=True)
class WorldSpec:
    """A whole world; :func:`swarm_envs.load_world` makes one from a name or a file."""

    name: str
    arena: Arena
    robots: tuple[RobotModel, ...]
    """One model per robot, in the order of robots."""
    limits: Limits
    contact: Contact = field(default_factory=Contact)
    start: Start = field(default_factory=Start)
    objects: tuple[PushableObject, ...] = ()
    broadcast: Broadcast | None = None
    """Limited communication between robots; None where they have none."""
    tick: float = quantity("s", 0.1, low=1e-3, high=1.0)
    """Time from one command to the next."""
    description: str = ""
    provenance: Mapping[str, Provenance] = field(default_factory=dict, compare=False, repr=False)
    """Unit, source and note of every sourced number, keyed by dotted path."""

    @property
    def num_robots(self) -> int:
        """Number of robots."""
        return len(self.robots)

    @property
    def size(self) -> tuple[float, float]:
        """Width and height of the arena's bounding box in m."""
        xs, ys = zip(*self.arena.outline, strict=True)
        return max(xs) - min(xs), max(ys) - min(ys)

    @property
    def num_sensors(self) -> int:
        """Sensors per robot: those of the robot model with most."""
        return max(len(robot.sensors) for robot in self.robots)

    @property
    def num_readings(self) -> int:
        """Bits that a robot gets each tick: its sensors' readings, and whether it hears another where the world has a broadcast."""
        return self.num_sensors + (self.broadcast is not None)

    def with_robots(self, count: int, *, scale_arena: bool = False) -> Self:
        """Return this world with ``count`` robots, models repeated in order.

        Args:
            count: 1 to 1000.
            scale_arena: Grow or shrink the outline, obstacles and the objects' places so that the area per robot stays.

        Raises:
            WorldError: When ``count`` is out of range, or the robots do not fit.
        """
        if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= 1000:
            raise WorldError(f"{self.name}: num_robots is {count!r}, expected a whole number from 1 to 1000")
        world = dataclasses.replace(self, robots=tuple(self.robots[i % self.num_robots] for i in range(count)))
        if scale_arena:
            factor = math.sqrt(count / self.num_robots)
            obstacles = tuple(dataclasses.replace(o, outline=_scaled(o.outline, factor)) for o in self.arena.obstacles)
            arena = dataclasses.replace(self.arena, outline=_scaled(self.arena.outline, factor), obstacles=obstacles)
            objects = tuple(dataclasses.replace(o, pose=(o.pose[0] * factor, o.pose[1] * factor, o.pose[2])) for o in self.objects)
            world = dataclasses.replace(world, arena=arena, objects=objects)
        return world

    def replace(self, **changes: Any) -> Self:
        """Return a copy with fields replaced, as :func:`dataclasses.replace`."""
        return dataclasses.replace(self, **changes)

    def with_effects(self, **changes: float) -> Self:
        """Return a copy in which every robot's effects have the given fields changed."""
        robots = tuple(dataclasses.replace(r, effects=dataclasses.replace(r.effects, **changes)) for r in self.robots)
        return dataclasses.replace(self, robots=robots)


def _scaled(outline: Polygon, factor: float) -> Polygon:
    return tuple((x * factor, y * factor) for x, y in outline)

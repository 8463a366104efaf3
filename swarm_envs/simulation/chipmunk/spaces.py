"""Chipmunk's spaces, and the memory through which compiled code reaches them."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pymunk
from pymunk._chipmunk_cffi import ffi, lib

from swarm_envs.simulation.chipmunk.calls import (
    BODIES,
    GET_DATA,
    SET_DATA,
    SPACE,
    address,
    function_addresses,
    keep_still,
)
from swarm_envs.simulation.chipmunk.prediction import CONTACT_MARGIN
from swarm_envs.simulation.chipmunk.substeps import substeps_for
from swarm_envs.simulation.parameters import FloatArray, compile_world
from swarm_envs.simulation.state import StateArrays
from swarm_envs.worlds import WorldSpec

ITERATIONS = 8
"""Chipmunk's solver iterations in a substep; it starts from the impulses of the substep before."""
SLOP = 2e-4
"""Overlap in m that Chipmunk leaves alone; its default is 0.1 in the space's unit of length, which would be 10 cm."""
GRAVITY = 9.81
"""m/s^2, for the floor friction of pushable objects."""


class SpaceArrays(NamedTuple):
    """What compiled code needs to drive the Chipmunk spaces of W worlds (N bodies: robots, then objects)."""

    handles: npt.NDArray[np.int64]
    """(W, 9 + N) addresses of functions, space, batches and bodies."""
    counters: npt.NDArray[np.int32]
    """(W, 8) headers of the get and the set batch; columns 0 and 4 are the numbers of their values, written before each use."""
    get_values: FloatArray
    """(W, 6 (N + 2)) position, angle, velocity and spin of each body; the static body comes last, and pymunk grows a full batch."""
    set_values: FloatArray
    """(W, 5 (N + 2)) position, velocity and spin to be set; the static body comes last and gets zeros."""
    predicted: FloatArray
    """(W, R, 8) how each robot would move and how contact made it move in the substep before; columns in
    :mod:`swarm_envs.simulation.chipmunk.prediction`."""
    substeps: int
    """Substeps of a tick where nobody looks how fast robots approach: among objects, in a large swarm, of drives with effects."""


class Spaces:
    """The Chipmunk spaces of some worlds, and the memory through which compiled code reaches them.

    A space is built again at each start, since the order in which Chipmunk's tree has grown decides the order of contacts
    and so the last bits of a result.
    """

    def __init__(self, world: WorldSpec, num_worlds: int) -> None:
        self.world = world
        self._walls = compile_world(world).walls
        bodies = world.num_robots + len(world.objects)
        self._keep: list[list[Any]] = [[] for _ in range(num_worlds)]
        self._stale = set(range(num_worlds))
        self._counts = np.zeros((num_worlds, 2, 4), np.int32)  # pmFloatArray: num, max, then a pointer of 8 bytes
        self.arrays = SpaceArrays(
            handles=np.zeros((num_worlds, BODIES + bodies), np.int64),
            counters=self._counts.reshape(num_worlds, 8),
            get_values=np.zeros((num_worlds, 6 * (bodies + 2))),
            set_values=np.zeros((num_worlds, 5 * (bodies + 2))),
            predicted=np.zeros((num_worlds, world.num_robots, 8)),
            substeps=substeps_for(world),
        )
        self.arrays.handles[:, :SPACE] = function_addresses()

    def invalidate(self, worlds: npt.NDArray[np.int64]) -> None:
        """Have the spaces of the worlds with these indices built again before they are next used."""
        self._stale.update(worlds.tolist())

    def ready(self, state: StateArrays) -> SpaceArrays:
        """Return the memory of the spaces; invalid ones are built from the poses in ``state``."""
        for w in sorted(self._stale):
            self._build(w, state)
        self._stale.clear()
        return self.arrays

    def _build(self, w: int, state: StateArrays) -> None:
        self.arrays.predicted[w] = 0.0
        space = pymunk.Space()
        space.iterations, space.collision_slop = ITERATIONS, SLOP
        _add_walls(space, self.world, self._walls)
        bodies = [self._robot(space, i, state.poses[w, i]) for i in range(self.world.num_robots)]
        bodies += [self._object(space, b, state.objects[w, b]) for b in range(len(self.world.objects))]
        batches = [
            self._batch(w, 0, self.arrays.get_values[w], lib.POSITION | lib.ANGLE | lib.VELOCITY | lib.ANGULAR_VELOCITY),
            self._batch(w, 1, self.arrays.set_values[w], lib.POSITION | lib.VELOCITY | lib.ANGULAR_VELOCITY),
        ]
        self._keep[w] = [space, bodies, batches]
        handles = self.arrays.handles[w]
        handles[SPACE] = address(space._space)
        handles[GET_DATA], handles[SET_DATA] = (address(batch) for batch, _ in batches)
        handles[BODIES:] = [address(body._body) for body in bodies]

    def _batch(self, w: int, which: int, values: FloatArray, fields: int) -> tuple[Any, Any]:
        """A pmBatchedData over numpy memory; the pair's second part must outlive the first's use."""
        array = ffi.cast("pmFloatArray *", self._counts[w, which].ctypes.data)
        array.num, array.max, array.arr = 0, len(values), ffi.cast("double *", values.ctypes.data)
        batch, integers = ffi.new("pmBatchedData *"), ffi.new("pmIntArray *")
        batch.floatArray, batch.intArray, batch.fields = array, integers, fields
        return batch, integers

    def _robot(self, space: pymunk.Space, i: int, pose: FloatArray) -> pymunk.Body:
        model = self.world.robots[i].body
        body = pymunk.Body(model.mass, model.inertia_ratio * model.mass * model.contact_radius**2)
        shape = pymunk.Circle(body, model.contact_radius + CONTACT_MARGIN)
        return _add(space, self.world, body, shape, pose)

    def _object(self, space: pymunk.Space, b: int, pose: FloatArray) -> pymunk.Body:
        item = self.world.objects[b]
        if item.shape == "disc":
            body = pymunk.Body(item.mass, pymunk.moment_for_circle(item.mass, 0.0, item.size[0]))
            shape: pymunk.Shape = pymunk.Circle(body, item.size[0])
        else:
            body = pymunk.Body(item.mass, pymunk.moment_for_box(item.mass, (item.size[0], item.size[1])))
            shape = pymunk.Poly.create_box(body, (item.size[0], item.size[1]))
        _add(space, self.world, body, shape, pose)
        # the floor's friction is a constraint of bounded force, solved together with the contacts
        slide, spin = pymunk.PivotJoint(space.static_body, body, body.position), pymunk.GearJoint(space.static_body, body, 0.0, 1.0)
        slide.max_bias = spin.max_bias = 0.0
        slide.max_force = item.floor_friction * item.mass * GRAVITY
        # mean distance of the footprint from its centre: two thirds of the radius of a disc of the same area
        mean_radius = 2.0 / 3.0 * math.sqrt(shape.area / math.pi)
        spin.max_force = slide.max_force * mean_radius
        space.add(slide, spin)
        return body


def _add(space: pymunk.Space, world: WorldSpec, body: pymunk.Body, shape: pymunk.Shape, pose: FloatArray) -> pymunk.Body:
    body.position, body.angle = (float(pose[0]), float(pose[1])), float(pose[2])
    contact = world.contact
    shape.friction = _shares(contact.robot_friction, contact.wall_friction)[0]
    shape.elasticity = _shares(contact.robot_restitution, contact.wall_restitution)[0]
    space.add(body, shape)
    lib.cpBodySetPositionUpdateFunc(body._body, ffi.cast("cpBodyPositionFunc", keep_still.address))
    return body


def _shares(with_robot: float, with_wall: float) -> tuple[float, float]:
    """Split a robot-robot and a robot-wall coefficient into a robot's and a wall's; Chipmunk multiplies the two of a contact."""
    robot = math.sqrt(max(with_robot, 1e-12))
    return robot, with_wall / robot


def _add_walls(space: pymunk.Space, world: WorldSpec, walls: FloatArray) -> None:
    """Add walls and obstacles as segments without thickness; a robot that covers less than its radius in a substep cannot pass one."""
    contact = world.contact
    for x, y, ux, uy, length in walls.tolist():
        segment = pymunk.Segment(space.static_body, (x, y), (x + ux * length, y + uy * length), 0.0)
        segment.friction = _shares(contact.robot_friction, contact.wall_friction)[1]
        segment.elasticity = _shares(contact.robot_restitution, contact.wall_restitution)[1]
        space.add(segment)

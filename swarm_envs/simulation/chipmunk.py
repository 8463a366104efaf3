"""The contact law by Chipmunk: discs, boxes and polygons, driven from compiled code.

``cpSpaceStep`` moves bodies with the velocities of the step before and solves contacts afterwards, so a desired velocity
written into a body before the step would move it unsolved. Here the bodies' position function does nothing; a substep is: write the desired
velocities, step (find contacts, solve), then move every body with the solved velocity. The solver has the last word and a command acts
without delay.

A tick has as many substeps as its contacts need: none where nothing is near, few for walls, whose normals stay. What contact did in the
substep before tells when blocked robots will touch others, and where they will be and head in the substep's middle: there the
solver finds contacts and desired velocities, which makes sliding and turning accurate to second order.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pymunk
from pymunk._chipmunk_cffi import ffi, lib

from swarm_envs.compiled import compiled
from swarm_envs.simulation.actuation import drive
from swarm_envs.simulation.chipmunk_calls import (
    BODIES,
    EACH_BODY,
    GET_BATCH,
    GET_DATA,
    MOVE_BODY,
    SET_BATCH,
    SET_BIAS,
    SET_DATA,
    SPACE,
    STEP,
    address,
    call_with_double,
    call_with_pointers,
    function_addresses,
    keep_still,
)
from swarm_envs.simulation.parameters import FeatureFlag, FloatArray, WorldArrays, compile_world
from swarm_envs.simulation.state import StateArrays
from swarm_envs.simulation.touching import (
    BLOCKED,
    CONTACT_MARGIN,
    DESIRED_X,
    DESIRED_Y,
    LARGE_SWARM,
    LAST_SPEED,
    SOLVED_X,
    SOLVED_Y,
    TURN_BY_CONTACT,
    beyond_end,
    contacts_persist,
    robots_within,
    time_of_impact,
    wall_within,
)
from swarm_envs.simulation.trigonometry import cos_sin
from swarm_envs.worlds import WorldSpec

ITERATIONS = 8
"""Chipmunk's solver iterations in a substep; it starts from the impulses of the substep before."""
SLOP = 2e-4
"""Overlap in m that Chipmunk leaves alone; its default is 0.1 in the space's unit of length, which would be 10 cm."""
OVERLAP_HALF_LIFE = 1.0 / 60.0
"""Seconds in which half of an overlap is gone."""
MAX_CLOSING = 0.006
"""Two robots near each other may change their distance by at most this many metres in a substep; see :func:`substeps_now`."""
STEADY_COMMAND = 1e-3
"""A robot that sets out at a speed or turn rate within this many m/s or rad/s of the tick before still does the same."""
WALL_SUBSTEPS = 2
"""Least substeps of a tick in which a robot may touch a wall: its heading turns."""
LATTICE = 100
"""A substep begins and ends on this lattice of a tick; one in which robots first touch ends on the next point after the touch."""
SUBSTEPS = (1, 2, 4, 5, 10, 20)
"""Allowed substeps: divisors of the drive's own lattice of pieces."""
GRAVITY = 9.81
"""m/s^2, for the floor friction of pushable objects."""


class SpaceArrays(NamedTuple):
    """What compiled code needs to drive the Chipmunk spaces of W worlds (N bodies: robots, then objects)."""

    handles: npt.NDArray[np.int64]
    """(W, 9 + N) addresses of functions, space, batches and bodies."""
    counters: npt.NDArray[np.int32]
    """(W, 2) numbers of values in the get and the set batch, written before each use."""
    get_values: FloatArray
    """(W, 6 (N + 2)) position, angle, velocity and spin of each body; the static body comes last, and pymunk grows a full batch."""
    set_values: FloatArray
    """(W, 5 (N + 2)) position, velocity and spin to be set; the static body comes last and gets zeros."""
    predicted: FloatArray
    """(W, R, 8) how each robot would move and how contact made it move in the substep before; columns in :mod:`touching`."""
    substeps: int
    """Substeps of a tick where nobody looks how fast robots approach: among objects, in a large swarm, of drives with effects."""


def substeps_for(world: WorldSpec) -> int:
    """Return the substeps of a tick that keep the overlap of robots below 5 mm, for speeds up to 0.36 m/s at a tick of 0.1 s.

    Faster robots get the largest number there is and overlap more; the disc engine has no such limit.
    """
    closing = 2.0 * compile_world(world).reach
    return next((n for n in SUBSTEPS if closing / n <= MAX_CLOSING), SUBSTEPS[-1])


class Spaces:
    """The Chipmunk spaces of some worlds, and the memory through which compiled code reaches them.

    A space is built again at each start, since the order in which Chipmunk's tree has grown decides the order of contacts
    and so the last bits of a result.
    """

    def __init__(self, world: WorldSpec, num_worlds: int) -> None:
        self.world = world
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
        _add_walls(space, self.world)
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


def _add_walls(space: pymunk.Space, world: WorldSpec) -> None:
    """Add walls and obstacles as segments without thickness; a robot that covers less than its radius in a substep cannot pass one."""
    contact = world.contact
    for x, y, ux, uy, length in compile_world(world).walls.tolist():
        segment = pymunk.Segment(space.static_body, (x, y), (x + ux * length, y + uy * length), 0.0)
        segment.friction = _shares(contact.robot_friction, contact.wall_friction)[1]
        segment.elasticity = _shares(contact.robot_restitution, contact.wall_restitution)[1]
        space.add(segment)


@compiled(inline="always", _nrt=False)
def advance(world: WorldArrays, state: StateArrays, spaces: SpaceArrays, w: int, desired: FloatArray, effects: FeatureFlag) -> None:
    """Move the robots and objects of world ``w`` through one tick with contact; ``desired`` (R, 3) is scratch."""
    handles = spaces.handles[w]
    counters = spaces.counters[w]
    predicted = spaces.predicted[w]
    known = world.objects.shape[0] == 0 and desired.shape[0] <= LARGE_SWARM
    predict_velocities(world, state, w, predicted)
    substeps = substeps_needed(world, state.poses[w], predicted, spaces.substeps) if known else spaces.substeps
    if commands_changed(world, state, w, predicted):
        # what contact did tells nothing of what it will do now
        for i in range(desired.shape[0]):
            predicted[i, BLOCKED] = predicted[i, TURN_BY_CONTACT] = 0.0
        predict_velocities(world, state, w, predicted)
    longest = (LATTICE + substeps - 1) // substeps if substeps > 0 else LATTICE
    at = 0
    while at < LATTICE:
        until = min(LATTICE, at + longest)
        if substeps > 0 and desired.shape[0] <= LARGE_SWARM:
            if at > 0:
                predict_velocities(world, state, w, predicted)
            impact = time_of_impact(world, state.poses[w], predicted)
            if impact * LATTICE < (until - at) * world.tick:
                until = at + int(impact / world.tick * LATTICE) + 1
        duration = (until - at) * world.tick / LATTICE
        drive(world, state, w, at / LATTICE, until / LATTICE, desired, effects)
        turn_to_midpoint(desired, predicted, duration)
        ahead = 0.5 * duration if known and contacts_persist(world, state.poses[w], predicted, 0.5 * duration) else 0.0
        write_bodies(world, state, w, desired, predicted, ahead, spaces.set_values[w])
        counters[4] = 0
        call_with_pointers(handles[EACH_BODY], handles[SPACE], handles[SET_BATCH], handles[SET_DATA])
        # bodies are given velocities, so the impulses that Chipmunk remembers hold whatever a substep's length: its step is always the same
        solver_step = world.tick / spaces.substeps
        call_with_double(handles[SET_BIAS], handles[SPACE], collision_bias(duration, solver_step))
        call_with_double(handles[STEP], handles[SPACE], solver_step)
        for b in range(BODIES, handles.shape[0]):
            call_with_double(handles[MOVE_BODY], handles[b], duration)
        counters[0] = 0
        call_with_pointers(handles[EACH_BODY], handles[SPACE], handles[GET_BATCH], handles[GET_DATA])
        read_bodies(state, w, spaces.set_values[w], spaces.get_values[w])
        record_solution(predicted, desired, spaces.get_values[w])
        at = until


@compiled(forceinline=True, _nrt=False)
def commands_changed(world: WorldArrays, state: StateArrays, w: int, predicted: FloatArray) -> bool:
    """Whether any robot sets out otherwise than in the tick before; note how."""
    found = False
    for i in range(predicted.shape[0]):
        for k in range(2):
            now = state.latched_commands[w, i, k] if world.ideal_drive else state.drive_velocity[w, i, k]
            found = found or abs(now - predicted[i, LAST_SPEED + k]) > STEADY_COMMAND
            predicted[i, LAST_SPEED + k] = now
    return found


@compiled(forceinline=True, _nrt=False)
def predict_velocities(world: WorldArrays, state: StateArrays, w: int, predicted: FloatArray) -> None:
    """Write the velocities with which robots set out: the desired ones, and as contact lets those that it blocked."""
    for i in range(predicted.shape[0]):
        c, s = cos_sin(state.poses[w, i, 2])
        speed = state.latched_commands[w, i, 0] if world.ideal_drive else state.drive_velocity[w, i, 0]
        predicted[i, DESIRED_X], predicted[i, DESIRED_Y] = speed * c, speed * s
        if predicted[i, BLOCKED] == 0.0:
            predicted[i, SOLVED_X], predicted[i, SOLVED_Y] = predicted[i, DESIRED_X], predicted[i, DESIRED_Y]


@compiled(forceinline=True, _nrt=False)
def substeps_needed(world: WorldArrays, poses: FloatArray, predicted: FloatArray, most: int) -> int:
    """Return the substeps of a tick, 0 where nothing is near enough to touch.

    Near pairs count with the fastest relative velocity they can have: either may be blocked by others, or no longer. So do robots past
    the end of a wall, whose touch is not predicted. A drive with effects gets ``most``: dead time, lag or a wheel that is freed change
    its speed inside the tick, and how it sets out tells nothing.
    """
    fastest, pair, wall = 0.0, False, False
    for i in range(poses.shape[0]):
        for j in range(i):
            if robots_within(world, poses, i, j, 2.0 * world.reach):
                pair = True
                for a in (DESIRED_X, SOLVED_X):
                    for b in (DESIRED_X, SOLVED_X):
                        vx, vy = predicted[j, b] - predicted[i, a], predicted[j, b + 1] - predicted[i, a + 1]
                        fastest = max(fastest, vx * vx + vy * vy)
        for e in range(world.walls.shape[0]):
            if wall_within(world, poses, i, e, 2.0 * world.reach):
                wall = True
                if beyond_end(world, poses, i, e):
                    for a in (DESIRED_X, SOLVED_X):
                        fastest = max(fastest, predicted[i, a] ** 2 + predicted[i, a + 1] ** 2)
    if not pair and not wall:
        return 0
    if not world.ideal_drive:
        return most
    return max(math.ceil(math.sqrt(fastest) / MAX_CLOSING * world.tick - 1e-6), WALL_SUBSTEPS if wall else 1)


@compiled(forceinline=True, _nrt=False)
def collision_bias(duration: float, solver_step: float) -> float:
    """Return Chipmunk's collision bias, the share of an overlap that it would leave after a second, for a substep of ``duration`` s.

    It pushes bodies apart with the velocity that takes 1 - bias^solver_step of the overlap away in ``solver_step`` s, but they move for
    ``duration``.
    """
    pushed = (1.0 - 0.5 ** (duration / OVERLAP_HALF_LIFE)) * solver_step / duration
    return float(max(1.0 - pushed, 0.0) ** (1.0 / solver_step))


@compiled(forceinline=True, _nrt=False)
def turn_to_midpoint(desired: FloatArray, predicted: FloatArray, duration: float) -> None:
    """Turn desired velocities as far as contact, judging by the last substep, turns robots until the middle of the next ``duration`` s."""
    for i in range(desired.shape[0]):
        if predicted[i, TURN_BY_CONTACT] != 0.0:
            c, s = cos_sin(0.5 * duration * predicted[i, TURN_BY_CONTACT])
            desired[i, 0], desired[i, 1] = c * desired[i, 0] - s * desired[i, 1], s * desired[i, 0] + c * desired[i, 1]


@compiled(forceinline=True, _nrt=False)
def record_solution(predicted: FloatArray, desired: FloatArray, values: FloatArray) -> None:
    """Note what contact made of the desired velocities."""
    for i in range(predicted.shape[0]):
        vx, vy = values[6 * i + 3], values[6 * i + 4]
        predicted[i, BLOCKED] = vx != desired[i, 0] or vy != desired[i, 1]
        predicted[i, SOLVED_X], predicted[i, SOLVED_Y] = vx, vy
        predicted[i, TURN_BY_CONTACT] = values[6 * i + 5] - desired[i, 2]


@compiled(forceinline=True, _nrt=False)
def write_bodies(
    world: WorldArrays, state: StateArrays, w: int, desired: FloatArray, predicted: FloatArray, ahead: float, values: FloatArray
) -> None:
    """Lay out what the solver starts from: desired velocities, and robots where they will be after ``ahead`` s."""
    robots = desired.shape[0]
    for i in range(robots):
        values[5 * i] = state.poses[w, i, 0] + ahead * predicted[i, SOLVED_X]
        values[5 * i + 1] = state.poses[w, i, 1] + ahead * predicted[i, SOLVED_Y]
        for k in range(3):
            values[5 * i + 2 + k] = desired[i, k]
    for b in range(world.objects.shape[0]):
        at = 5 * (robots + b)
        values[at], values[at + 1] = state.objects[w, b, 0], state.objects[w, b, 1]
        for k in range(3):
            values[at + 2 + k] = state.objects[w, b, 3 + k]


@compiled(forceinline=True, _nrt=False)
def read_bodies(state: StateArrays, w: int, given: FloatArray, values: FloatArray) -> None:
    """Copy poses of robots and poses and velocities of objects out of the batch; robots moved from where they were, not where given."""
    robots = state.poses.shape[1]
    for i in range(robots):
        for k in range(2):
            state.poses[w, i, k] += values[6 * i + k] - given[5 * i + k]
        state.poses[w, i, 2] = values[6 * i + 2]
    for b in range(state.objects.shape[1]):
        for k in range(6):
            state.objects[w, b, k] = values[6 * (robots + b) + k]

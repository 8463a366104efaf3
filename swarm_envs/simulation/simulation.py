"""Worlds that run: the object that every environment, study and calibration drives."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from swarm_envs.compiled import ENGINE_SECONDS, announce
from swarm_envs.simulation.chipmunk.spaces import SpaceArrays, Spaces
from swarm_envs.simulation.contacts import TOUCHING_GAP, contact_flags
from swarm_envs.simulation.disc.broad_phase import allocate_scratch
from swarm_envs.simulation.parameters import RADIUS, FeatureFlag, FloatArray, compile_world
from swarm_envs.simulation.randomness import world_keys
from swarm_envs.simulation.segments import wall_segments
from swarm_envs.simulation.start import check_start, object_starts, start_worlds
from swarm_envs.simulation.state import StateArrays, empty_state
from swarm_envs.simulation.stepping import feature_flags, run_worlds, sense_worlds, step_worlds
from swarm_envs.worlds import WorldError, WorldSpec, load_world
from swarm_envs.worlds.geometry import start_points

Engine = Literal["chipmunk", "disc"]
ENGINES: tuple[Engine, ...] = ("chipmunk", "disc")


class Simulation:
    """W copies of one world, run tick by tick or with controllers.

    Args:
        world: A world's name, file or spec.
        num_worlds: W.
        engine: ``chipmunk`` (pymunk; anything a world may hold) or ``disc`` (compiled; discs in polygons).

    Raises:
        WorldError: For an unknown world or engine, or a world that the engine cannot represent.
    """

    def __init__(self, world: str | Path | WorldSpec, num_worlds: int = 1, engine: str = "chipmunk") -> None:
        if num_worlds < 0:
            raise WorldError(f"num_worlds is {num_worlds}, expected at least 0")
        self.world = load_world(world)
        self.engine = check_engine(self.world, engine)
        self.num_worlds = num_worlds
        self._parameters = compile_world(self.world)
        self._feature_flags = feature_flags(self._parameters)
        _announce(self.engine, *self._feature_flags)
        self._state = empty_state(self._parameters, num_worlds)
        self._points = start_points(self.world)
        self._walls = wall_segments(self.world)
        self._objects = object_starts(self.world)
        self._scratch = allocate_scratch(self._parameters)
        self._spaces = Spaces(self.world, self.num_worlds) if self.engine == "chipmunk" else None
        self.reset(0)

    def reset(
        self, seed: int | Sequence[int] = 0, *, first: int = 0, keys: npt.NDArray[np.uint64] | None = None,
        which: npt.NDArray[np.int64] | None = None, initial_poses: FloatArray | None = None,
    ) -> None:  # fmt: skip
        """Put worlds at their start and take the first readings.

        Args:
            seed: World ``w`` draws everything from (seed, first + w).
            first: See ``seed``.
            keys: (number of worlds reset,) keys to draw from instead of ``seed``.
            which: Indices of the worlds to reset; all by default.
            initial_poses: (number of worlds reset, R, 3) x, y in m and heading in rad instead of drawn ones.

        Raises:
            WorldError: When the given poses do not fit.
        """
        worlds = np.arange(self.num_worlds) if which is None else np.asarray(which, np.int64)
        if worlds.size and not 0 <= worlds.min() <= worlds.max() < self.num_worlds:
            raise WorldError(f"which names world {worlds.max()}, expected indices from 0 to {self.num_worlds - 1}")
        drawn = world_keys(seed, first, len(worlds)) if keys is None else keys
        given = None if initial_poses is None else self._given_poses(initial_poses, len(worlds))
        start_worlds(self._parameters, self._state, worlds, drawn, self._points, self._objects)
        if given is not None:
            self._state.poses[worlds] = given
        if self._spaces is not None:
            self._spaces.invalidate(worlds)
        sense_worlds(self._parameters, self._state, worlds, self._scratch, *self._feature_flags)

    def step(self, commands: npt.ArrayLike, messages: npt.ArrayLike | None = None) -> None:
        """Run every world through one tick.

        Args:
            commands: (W, R, 2) v in m/s and omega in rad/s.
            messages: (W, R) whether each robot broadcasts during the tick, where the world has a broadcast; nobody does by default.

        Raises:
            WorldError: For another shape, a value that is not finite, or messages in a world without broadcast.
        """
        array = np.ascontiguousarray(commands, dtype=np.float64)
        expected = (self.num_worlds, self.world.num_robots, 2)
        if array.shape != expected or not np.isfinite(array).all():
            given = f"shape {array.shape}" if array.shape != expected else "a value that is not finite"
            raise WorldError(f"commands: given {given}, expected {expected} finite speeds (worlds, robots, v omega) in m/s and rad/s")
        self._send(messages)
        step_worlds(self._parameters, self._state, self._ready_spaces(), *self._feature_flags, array, self._scratch)

    def observe(self) -> None:
        """Take readings again, and tell the engine, for those who have moved robots by writing to :attr:`poses`."""
        worlds = np.arange(self.num_worlds)
        if self._spaces is not None:
            self._spaces.invalidate(worlds)
        sense_worlds(self._parameters, self._state, worlds, self._scratch, *self._feature_flags)

    def run(
        self, controllers: FloatArray, steps: int, every: int, poses: FloatArray, detections: npt.NDArray[np.uint8], commands: FloatArray
    ) -> None:
        """Run every world with its controllers and write the recorded frames.

        The arguments are those of :func:`swarm_envs.simulation.stepping.run_worlds`.

        Raises:
            WorldError: When an array has another shape.
        """
        frames = (self.num_worlds, steps // every + 1, self.world.num_robots)
        expected = [(*frames, 3), (*frames, self.world.num_readings), (*frames, 2)]
        if [poses.shape, detections.shape, commands.shape] != expected or controllers.shape[:2] != (frames[0], frames[2]):
            raise WorldError(f"run: arrays do not have the shapes {expected}, or controllers not ({frames[0]}, {frames[2]}, numbers)")
        run_worlds(
            self._parameters, self._state, self._ready_spaces(), *self._feature_flags, controllers, steps, every,
            self._scratch, poses, detections, commands,
        )  # fmt: skip

    @property
    def time(self) -> FloatArray:
        """(W,) s since each world's start."""
        return np.asarray(self._state.ticks * self.world.tick, dtype=np.float64)

    @property
    def poses(self) -> FloatArray:
        """(W, R, 3) x and y in m, heading in rad; a view of the running state."""
        return self._state.poses

    @property
    def detections(self) -> npt.NDArray[np.uint8]:
        """(W, R) readings, or (W, R, S) where robots have S > 1: one per sensor, with a broadcast one more; a view of the running state."""
        readings = self._state.detections
        return readings[:, :, 0] if readings.shape[2] == 1 else readings

    @property
    def objects(self) -> FloatArray:
        """(W, B, 3) poses of the pushable objects in m, m, rad; a view of the running state."""
        return self._state.objects[:, :, :3]

    @property
    def touching(self) -> npt.NDArray[np.uint8]:
        """(W, R) sums of :data:`~swarm_envs.simulation.contacts.ROBOT_CONTACT` (1) and ``WALL_CONTACT`` (2): what each robot touches."""
        return np.asarray(contact_flags(self._state.poses, self._parameters.robots[:, RADIUS].copy(), self._walls, TOUCHING_GAP))

    @property
    def state(self) -> StateArrays:
        """Everything that changes, for those who look inside."""
        return self._state

    def _ready_spaces(self) -> SpaceArrays | None:
        return None if self._spaces is None else self._spaces.ready(self._state)

    def _send(self, messages: npt.ArrayLike | None) -> None:
        if messages is None:
            if self.world.broadcast is not None:
                self._state.messages[:] = 0
            return
        sent, expected = np.asarray(messages), (self.num_worlds, self.world.num_robots)
        if self.world.broadcast is None:
            raise WorldError(f"messages are given, but world {self.world.name!r} has no broadcast; give it one (broadcast: {{range: ...}})")
        if sent.shape != expected:
            raise WorldError(f"messages: shape is {sent.shape}, expected {expected} (worlds, robots)")
        self._state.messages[:] = sent != 0

    def _given_poses(self, poses: npt.ArrayLike, count: int) -> FloatArray:
        array = np.array(poses, dtype=np.float64)
        expected = (count, self.world.num_robots, 3)
        if array.shape != expected:
            raise WorldError(f"initial_poses: shape is {array.shape}, expected {expected} (worlds, robots, x y heading)")
        check_start(self.world, array)
        return array

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_spaces"}

    def __setstate__(self, content: dict[str, Any]) -> None:
        """Restore; Chipmunk's spaces are rebuilt from the poses, so only ``disc`` continues to the last bit."""
        self.__dict__.update(content)
        self._spaces = Spaces(self.world, self.num_worlds) if self.engine == "chipmunk" else None


def check_engine(world: WorldSpec, engine: str) -> Engine:
    """Return the engine if it exists and can represent the world.

    Raises:
        WorldError: Otherwise, with the reason.
    """
    if engine == "chipmunk":
        return "chipmunk"
    if engine == "disc":
        if world.objects:
            raise WorldError(f"{world.name}: engine 'disc' cannot push objects, the world has {len(world.objects)}; use engine='chipmunk'")
        return "disc"
    raise WorldError(f"engine is {engine!r}, expected one of {', '.join(ENGINES)}")


def announce_engine(world: str | Path | WorldSpec, engine: str) -> None:
    """Say in one line on stderr, once per state of the sources, that an engine will be compiled for a world.

    Every :class:`Simulation` says so itself. This is for programs that have something slow to do before they make one.

    Args:
        world: A world's name, file or spec.
        engine: ``chipmunk`` or ``disc``.

    Raises:
        WorldError: For an unknown world or engine, or a world that the engine cannot represent.
    """
    spec = load_world(world)
    _announce(check_engine(spec, engine), *feature_flags(compile_world(spec)))


def _announce(engine: Engine, effects: FeatureFlag, grid: FeatureFlag) -> None:
    variant = f"{' with effects' if effects else ''}{' for large swarms' if grid else ''}"
    announce(f"compiling the {engine} engine{variant} on first use; up to {ENGINE_SECONDS} seconds, once")

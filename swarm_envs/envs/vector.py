"""Many swarms at once: a native vector environment, every world stepped by one call into compiled code."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from swarm_envs.envs.interface import (
    RENDER_FPS,
    check_render_mode,
    checked_actions,
    draw_key,
    swarm_action_space,
    swarm_observation_space,
)
from swarm_envs.envs.parallel import EPISODE_TICKS
from swarm_envs.envs.tasks import Task, make_rewards
from swarm_envs.rendering import Renderer
from swarm_envs.simulation import Simulation
from swarm_envs.worlds import WorldSpec, load_world

Observations = npt.NDArray[np.int8]
RENDER_MODES = ["rgb_array"]
"""A window would show one copy of many: pictures only."""


class SwarmVectorEnv(VectorEnv[Observations, npt.NDArray[np.float32], npt.NDArray[np.float64]]):
    """``num_envs`` copies of :class:`swarm_envs.envs.SwarmEnv` in one simulation.

    Spaces, rewards, starts and episodes are the scalar environment's, and so is every bit of a run on the same engine:
    copy ``i`` of a reset with seed ``s`` is a scalar environment reset with ``s + i``. The default engine is ``disc``, the faster for
    many worlds, while ``gym.make`` takes ``chipmunk``: give both the same ``engine`` where they have to agree to the last bit.

    Args:
        num_envs: Number of copies, N.
        world: A world's name, file or spec.
        num_robots: Number of robots instead of the world's own.
        engine: ``disc`` or ``chipmunk``.
        render_mode: ``rgb_array`` or None.
        task: What the swarms are rewarded for: a name, a function as in :class:`swarm_envs.envs.SwarmEnv`, or None.
        max_episode_steps: Ticks after which a copy is truncated; None for never.
        autoreset_mode: When a copy whose episode is over starts again: at the next step, in the same step, or never by itself
            (``reset(options={"reset_mask": mask})``).

    Raises:
        ValueError: For an unknown world, engine, render mode or task; one line.
    """

    def __init__(
        self,
        num_envs: int = 1,
        world: str | Path | WorldSpec = "hero_plus",
        num_robots: int | None = None,
        engine: str = "disc",
        render_mode: str | None = None,
        task: str | Task | None = None,
        max_episode_steps: int | None = EPISODE_TICKS,
        autoreset_mode: str | AutoresetMode = AutoresetMode.NEXT_STEP,
    ) -> None:
        super().__init__()
        self.world = load_world(world, num_robots=num_robots)
        self.num_envs, self.render_mode, self.max_episode_steps = num_envs, check_render_mode(render_mode, RENDER_MODES), max_episode_steps
        self.autoreset_mode = AutoresetMode(autoreset_mode)
        self.metadata = {"render_modes": RENDER_MODES, "render_fps": RENDER_FPS, "autoreset_mode": self.autoreset_mode}
        self._rewards = make_rewards(task, self.world)
        self._simulation = Simulation(self.world, num_envs, engine)
        self.single_observation_space = swarm_observation_space(self.world)
        self.single_action_space = swarm_action_space(self.world)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._generators: list[np.random.Generator] = []
        self._over = np.zeros(num_envs, np.bool_)
        self._renderer = Renderer(self.world) if render_mode else None

    def reset(
        self, *, seed: int | Sequence[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observations, dict[str, Any]]:
        """Start episodes.

        Args:
            seed: Copy i draws from ``seed + i``, or from ``seed[i]``; None goes on with the generators of before.
            options: ``reset_mask`` (N,) which copies to reset, all by default; ``initial_poses`` (number reset, R, 3).
        """
        mask = np.asarray((options or {}).get("reset_mask", np.ones(self.num_envs, np.bool_)), dtype=np.bool_)
        if seed is None or isinstance(seed, int | np.integer):
            seeds = [None if seed is None else int(seed) + i for i in range(self.num_envs)]
        else:
            seeds = [None if each is None else int(each) for each in seed]
        if mask.shape != (self.num_envs,) or len(seeds) != self.num_envs:
            raise ValueError(f"seed has {len(seeds)} entries and reset_mask {mask.shape}, expected {self.num_envs} each, one for each copy")
        if not self._generators:
            self._generators = [seeding.np_random(each)[0] for each in seeds]
        else:
            for i in np.flatnonzero(mask):
                if seeds[i] is not None:
                    self._generators[i] = seeding.np_random(seeds[i])[0]
        self._start(mask, (options or {}).get("initial_poses"))
        return self._observe(), self._infos()

    def step(  # type: ignore[override]  # the base class types flags as it types rewards
        self, actions: npt.ArrayLike
    ) -> tuple[Observations, npt.NDArray[np.float64], npt.NDArray[np.bool_], npt.NDArray[np.bool_], dict[str, Any]]:
        """Run one tick of every copy with actions (N, R, 2), or (N, R, 3) in a world with a broadcast."""
        commands, messages = checked_actions(actions, (self.num_envs,), self.world)
        if not self._generators:
            raise ValueError("step was called before reset; call reset(seed=...) first")
        fresh = self._over if self.autoreset_mode == AutoresetMode.NEXT_STEP else np.zeros_like(self._over)
        if self.autoreset_mode == AutoresetMode.DISABLED and self._over.any():
            raise ValueError(
                f"copy {int(self._over.argmax())} is over and autoreset is disabled; reset(options={{'reset_mask': mask}}) it first"
            )
        before = self._simulation.poses.copy()
        self._simulation.step(commands, messages)
        rewards = np.array(self._rewards(before, self._simulation.poses), dtype=np.float64)
        rewards[fresh] = 0.0
        if fresh.any():
            self._start(fresh, None)
        ticks = self._simulation.state.ticks
        truncated = np.zeros_like(fresh) if self.max_episode_steps is None else ticks >= self.max_episode_steps
        self._over = truncated.copy()
        infos: dict[str, Any] = {}
        if self.autoreset_mode == AutoresetMode.SAME_STEP and truncated.any():
            infos = self._final(truncated)
            self._start(truncated, None)
            self._over[:] = False
        return self._observe(), rewards, np.zeros(self.num_envs, np.bool_), truncated, infos | self._infos()

    def render(self) -> tuple[npt.NDArray[np.uint8], ...] | None:
        """Return a picture (height, width, 3) of each copy."""
        if self._renderer is None:
            return None
        states = zip(self._simulation.poses, self._simulation.detections, self._simulation.objects, strict=True)
        return tuple(self._renderer(poses, seen, object_poses=objects) for poses, seen, objects in states)

    def _start(self, mask: npt.NDArray[np.bool_], poses: npt.ArrayLike | None) -> None:
        which = np.flatnonzero(mask)
        keys = np.concatenate([draw_key(self._generators[i]) for i in which]) if len(which) else np.empty(0, np.uint64)
        given = None if poses is None else np.asarray(poses, np.float64)
        self._simulation.reset(keys=keys, which=which, initial_poses=given)
        self._over[which] = False

    def _observe(self) -> Observations:
        return np.array(self._simulation.detections, dtype=np.int8)

    def _infos(self) -> dict[str, Any]:
        every = np.ones(self.num_envs, np.bool_)
        return {"poses": np.array(self._simulation.poses), "_poses": every, "time": np.array(self._simulation.time), "_time": every.copy()}

    def _final(self, over: npt.NDArray[np.bool_]) -> dict[str, Any]:
        """Last observations and infos of the episodes that end now, as Gymnasium's own vector environments give them."""
        observations = np.full(self.num_envs, None, dtype=object)
        for i in np.flatnonzero(over):
            observations[i] = np.array(self._simulation.detections[i], dtype=np.int8)
        final = {
            "poses": np.array(self._simulation.poses),
            "_poses": over.copy(),
            "time": np.array(self._simulation.time),
            "_time": over.copy(),
        }
        return {"final_obs": observations, "_final_obs": over.copy(), "final_info": final, "_final_info": over.copy()}

"""The swarm as many agents: a PettingZoo parallel environment."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.utils import seeding
from pettingzoo import ParallelEnv

from swarm_envs.envs.interface import RENDER_FPS, RENDER_MODES, action_columns, robot_action_space, robot_observation_space
from swarm_envs.envs.single_world import SingleWorld
from swarm_envs.envs.tasks import Task, environment_name
from swarm_envs.worlds import WorldSpec

Observation = npt.NDArray[np.int8]
EPISODE_TICKS = 600
"""Ticks of an episode (paper, Representation Learning: 600 timesteps)."""


class SwarmParallelEnv(ParallelEnv):  # type: ignore[misc]  # PettingZoo's classes carry no types
    """Eight cheap robots, one binary sensor each, every robot an agent.

    The world, the actions and the observations are those of :class:`swarm_envs.envs.SwarmEnv`, one robot's share per agent:
    actions ``Box((2,), float32)`` v in m/s and omega in rad/s, and in a world with a broadcast a third number, sent above 0.5;
    observations ``Box(0, 1, (readings,), int8)``; every agent gets the swarm's reward, zero without a task; all agents are truncated
    after ``max_ticks``. :meth:`state` is what a central critic may see.

    Args:
        world: A world's name, file or spec.
        num_robots: Number of robots instead of the world's own.
        engine: ``chipmunk`` or ``disc``.
        render_mode: ``rgb_array``, ``human`` for a window that follows every tick, or None.
        task: What the swarm is rewarded for: a name, a function as in :class:`swarm_envs.envs.SwarmEnv`, or None.
        max_ticks: Ticks of an episode.
    """

    metadata: ClassVar[dict[str, Any]] = {
        "name": "HeRo/Swarm-v0",
        "render_modes": RENDER_MODES,
        "render_fps": RENDER_FPS,
        "is_parallelizable": True,
    }

    def __init__(
        self,
        world: str | Path | WorldSpec = "hero_plus",
        num_robots: int | None = None,
        engine: str = "chipmunk",
        render_mode: str | None = None,
        task: str | Task | None = None,
        max_ticks: int = EPISODE_TICKS,
    ) -> None:
        self._single_world = SingleWorld(world, num_robots, engine, render_mode, task)
        self.world = self._single_world.world
        self.render_mode = render_mode
        if isinstance(task, str):
            self.metadata = {**self.metadata, "name": environment_name(task)}  # type: ignore[misc]  # of this instance alone
        self.max_ticks = max_ticks
        self.possible_agents = [f"robot_{i}" for i in range(self.world.num_robots)]
        # the same space object each time: wrappers and seeding rely on it
        self._observation_spaces = {agent: robot_observation_space(self.world) for agent in self.possible_agents}
        self._action_spaces = {agent: robot_action_space(self.world) for agent in self.possible_agents}
        self.state_space = spaces.Box(-np.inf, np.inf, (self.world.num_robots, 3), dtype=np.float32)
        self.agents: list[str] = []
        self._generator: np.random.Generator | None = None
        self._ticks = 0

    def observation_space(self, agent: str) -> spaces.Box:
        """Readings of one robot."""
        return self._observation_spaces[agent]

    def action_space(self, agent: str) -> spaces.Box:
        """Command of one robot: v in m/s, omega in rad/s."""
        return self._action_spaces[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Observation], dict[str, dict[str, Any]]]:
        """Start an episode; ``options`` as in :class:`swarm_envs.envs.SwarmEnv`."""
        if seed is not None or self._generator is None:
            self._generator, _ = seeding.np_random(seed)
        self._single_world.reset(self._generator, options)
        self.agents = list(self.possible_agents)
        self._ticks = 0
        return self._observations(), self._infos()

    def step(
        self, actions: dict[str, npt.NDArray[np.float32]]
    ) -> tuple[dict[str, Observation], dict[str, float], dict[str, bool], dict[str, bool], dict[str, dict[str, Any]]]:
        """Run one tick of the world with every agent's command.

        Raises:
            ValueError: When an agent's action is missing, of another shape, or not finite.
        """
        missing = [agent for agent in self.agents if agent not in actions]
        if missing:
            raise ValueError(
                f"actions lack {missing[0]!r}, expected one for each of {len(self.agents)} agents; commands of 0 let a robot stand"
            )
        if not self.agents:
            return {}, {}, {}, {}, {}
        columns = action_columns(self.world)
        for agent in self.agents:
            if np.shape(actions[agent]) != (len(columns),):
                raise ValueError(
                    f"action of {agent!r} has shape {np.shape(actions[agent])}, expected ({len(columns)},): {', '.join(columns)}"
                )
        self._single_world.advance(np.stack([np.asarray(actions[agent], dtype=np.float64) for agent in self.agents]))
        self._ticks += 1
        over = self._ticks >= self.max_ticks
        results = (
            self._observations(),
            dict.fromkeys(self.agents, self._single_world.reward),
            dict.fromkeys(self.agents, False),
            dict.fromkeys(self.agents, over),
            self._infos(),
        )
        if over:
            self.agents = []
        return results

    def render(self) -> npt.NDArray[np.uint8] | None:
        """Return the picture (height, width, 3) of the present moment; ``human`` shows it in the window instead and returns None."""
        return self._single_world.render()

    def state(self) -> npt.NDArray[np.float32]:
        """Poses of all robots (R, 3): x and y in m, heading in rad."""
        return self._single_world.poses().astype(np.float32)

    def close(self) -> None:
        """Close the window, if there is one."""
        self._single_world.close()

    def _observations(self) -> dict[str, Observation]:
        readings = self._single_world.detections().reshape(self.world.num_robots, -1)
        return {agent: readings[i].copy() for i, agent in enumerate(self.agents)}

    def _infos(self) -> dict[str, dict[str, Any]]:
        poses = self._single_world.poses()
        return {agent: {"pose": poses[i].copy()} for i, agent in enumerate(self.agents)}

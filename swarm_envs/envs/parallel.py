"""The swarm as many agents: a PettingZoo parallel environment."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
from gymnasium import spaces
from gymnasium.utils import seeding
from pettingzoo import ParallelEnv

from swarm_envs.envs.interface import RENDER_MODES, robot_action_space, robot_observation_space
from swarm_envs.envs.stage import Stage
from swarm_envs.worlds import WorldSpec

Observation = npt.NDArray[np.int8]
EPISODE_TICKS = 600
"""Ticks of an episode (paper, Representation Learning: 600 timesteps)."""


class SwarmParallelEnv(ParallelEnv):  # type: ignore[misc]  # PettingZoo's classes carry no types
    """Eight cheap robots, one binary sensor each, every robot an agent.

    The world, the actions and the observations are those of :class:`swarm_envs.envs.SwarmEnv`, one robot's share for each agent:
    actions ``Box((2,), float32)`` v in m/s and omega in rad/s; observations ``MultiBinary(sensors)``; rewards 0.0; all agents are
    truncated together after ``max_ticks``.

    Args:
        world: A world's name, file or spec.
        num_robots: Number of robots instead of the world's own.
        engine: ``chipmunk`` or ``disc``.
        render_mode: ``rgb_array`` or None.
        max_ticks: Ticks of an episode.
    """

    metadata: ClassVar[dict[str, Any]] = {
        "name": "HeRo/Swarm-v0",
        "render_modes": RENDER_MODES,
        "render_fps": 10,
        "is_parallelizable": True,
    }

    def __init__(
        self,
        world: str | Path | WorldSpec = "hero_plus",
        num_robots: int | None = None,
        engine: str = "chipmunk",
        render_mode: str | None = None,
        max_ticks: int = EPISODE_TICKS,
    ) -> None:
        self._stage = Stage(world, num_robots, engine, render_mode)
        self.world = self._stage.world
        self.render_mode = render_mode
        self.max_ticks = max_ticks
        self.possible_agents = [f"robot_{i}" for i in range(self.world.num_robots)]
        # the same space object each time: wrappers and seeding rely on it
        self._observation_spaces = {agent: robot_observation_space(self.world) for agent in self.possible_agents}
        self._action_spaces = {agent: robot_action_space(self.world) for agent in self.possible_agents}
        self.agents: list[str] = []
        self._generator: np.random.Generator | None = None
        self._ticks = 0

    def observation_space(self, agent: str) -> spaces.MultiBinary:
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
        self._stage.reset(self._generator, options)
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
        for agent in self.agents:
            if np.shape(actions[agent]) != (2,):
                raise ValueError(f"action of {agent!r} has shape {np.shape(actions[agent])}, expected (2,): v in m/s and omega in rad/s")
        self._stage.advance(np.stack([np.asarray(actions[agent], dtype=np.float64) for agent in self.agents]))
        self._ticks += 1
        over = self._ticks >= self.max_ticks
        results = (
            self._observations(),
            dict.fromkeys(self.agents, 0.0),
            dict.fromkeys(self.agents, False),
            dict.fromkeys(self.agents, over),
            self._infos(),
        )
        if over:
            self.agents = []
        return results

    def render(self) -> npt.NDArray[np.uint8] | None:
        """Return the picture (height, width, 3) of the present moment."""
        return self._stage.render()

    def close(self) -> None:
        """Nothing is held open."""

    def _observations(self) -> dict[str, Observation]:
        readings = self._stage.detections().reshape(self.world.num_robots, -1)
        return {agent: readings[i].copy() for i, agent in enumerate(self.agents)}

    def _infos(self) -> dict[str, dict[str, Any]]:
        poses = self._stage.poses()
        return {agent: {"pose": poses[i].copy()} for i, agent in enumerate(self.agents)}

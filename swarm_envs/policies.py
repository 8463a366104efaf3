"""Policies for the environments: what robots with a controller on board do, as actions."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import overload

import numpy as np
import numpy.typing as npt

from swarm_envs.envs.interface import robot_action_space
from swarm_envs.simulation import check_controllers
from swarm_envs.worlds import WorldSpec, load_world

Actions = npt.NDArray[np.float32]


class ControllerPolicy:
    """The if-else controller of the paper as a policy: readings to commands, for one swarm, many of them, or agents one by one.

    An environment whose robots carry the controller needs no policy: ``gym.make("HeRo/Swarm-v0", controller=controller)``.

    Args:
        controller: (4,) [v0, omega0, v1, omega1] in m/s and rad/s, or (R, 4) one for each robot; with S readings up to 2 * 2**S numbers,
            a pair for each pattern of readings.
        world: The environment's world: a name, a file or a spec.
        num_robots: Number of robots instead of the world's own.

    Raises:
        WorldError: For another shape, or a number outside the world's limits.

    Example:
        >>> import gymnasium as gym, swarm_envs
        >>> policy = ControllerPolicy([0.07, -1.3, 0.06, 1.1])
        >>> env = gym.make("HeRo/Swarm-v0")
        >>> seen, _ = env.reset(seed=0)
        >>> seen, *_ = env.step(policy(seen))
        >>> policy.act([1]).tolist()
        [0.05999999865889549, 1.100000023841858]
    """

    def __init__(self, controller: npt.ArrayLike, world: str | Path | WorldSpec = "hero_plus", num_robots: int | None = None) -> None:
        self.world = load_world(world, num_robots=num_robots)
        numbers = check_controllers(self.world, np.asarray(controller, dtype=np.float64)[None])[0]
        space = robot_action_space(self.world)
        pairs = numbers.reshape(self.world.num_robots, -1, 2)
        messages = np.zeros((*pairs.shape[:2], space.shape[0] - 2))  # robots with these controllers send nothing
        # float32 alone may round beyond the space's bounds
        self._commands: Actions = np.clip(np.concatenate([pairs, messages], axis=2).astype(np.float32), space.low, space.high)
        self._inputs = (pairs.shape[1] - 1).bit_length()

    @overload
    def __call__(self, observation: npt.NDArray[np.int8]) -> Actions: ...

    @overload
    def __call__(self, observation: Mapping[str, npt.NDArray[np.int8]]) -> dict[str, Actions]: ...

    def __call__(self, observation: npt.NDArray[np.int8] | Mapping[str, npt.NDArray[np.int8]]) -> Actions | dict[str, Actions]:
        """Return the action to an observation.

        Args:
            observation: (..., R) readings of Gymnasium's environment or vector environment, (..., R, S) with S > 1 readings per robot;
                or PettingZoo's, {agent: (S,)}.

        Returns:
            (..., R, 2) v in m/s and omega in rad/s, a third column of zeros in a world with a broadcast; or {agent: (2,)}.
        """
        if isinstance(observation, Mapping):
            return {agent: self.act(seen, int(agent.rsplit("_", 1)[1])) for agent, seen in observation.items()}
        readings = np.asarray(observation)
        if self.world.num_readings == 1:
            readings = readings[..., None]
        return self._commands[np.arange(self.world.num_robots), self._pattern(readings)]

    def act(self, observation: npt.ArrayLike, robot: int = 0) -> Actions:
        """Return one robot's action (2,) to its readings (S,)."""
        action: Actions = self._commands[robot, self._pattern(np.asarray(observation))]
        return action

    def _pattern(self, readings: npt.NDArray[np.int8]) -> npt.NDArray[np.int64]:
        weights = 1 << np.arange(self._inputs)
        return np.asarray(readings[..., : self._inputs].astype(np.int64) @ weights)

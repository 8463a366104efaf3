"""The swarm as one agent: a Gymnasium environment."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import numpy.typing as npt

from swarm_envs.envs.interface import RENDER_FPS, RENDER_MODES, swarm_observation_space
from swarm_envs.envs.single_world import SingleWorld
from swarm_envs.envs.tasks import Task
from swarm_envs.worlds import WorldSpec

Observation = npt.NDArray[np.int8]


class SwarmEnv(gym.Env[Observation, Any]):
    """Eight cheap robots, one binary sensor each, all under one agent.

    ## Description
    HeRo+ robots drive on a flat arena with walls that their sensor does not see. Each tick of 0.1 s the agent commands every robot's
    forward speed and turn rate; the robots move by unicycle kinematics with contact, friction and the effects of the world.
    A task says what is rewarded; this id has none. `swarm_envs.load_world` returns the world with its robots and numbers.

    ## Action Space
    `Box((num_robots, 2), float32)`: one row per robot. Values beyond the limits are clipped; NaN is an error.

    | Column | Action | Min | Max | Unit |
    |---|---|---|---|---|
    | 0 | forward speed v | -0.09 | 0.09 | m/s |
    | 1 | turn rate omega, counter-clockwise | -1.6 | 1.6 | rad/s |

    The bounds are those of `hero_plus`; other worlds have their own. In a world with a broadcast a third column from 0 to 1 is the
    robot's message: above 0.5 it sends during the tick.

    ## Observation Space
    `MultiBinary(num_robots)`: 1 where the robot's sensor sees another robot. With S > 1 readings, one per sensor and, with
    a broadcast, last whether the robot receives another's message, `MultiBinary((num_robots, S))`.

    ## Rewards
    The task's, from 0 to 1 each tick: `HeRo/Aggregation-v0`, `HeRo/CyclicPursuit-v0`, `HeRo/Dispersal-v0`, `HeRo/Milling-v0` and
    `HeRo/WallFollowing-v0` are this environment with a task (formulas: `swarm_envs.envs.tasks`). `HeRo/Swarm-v0` has none: 0.0.

    ## Starting State
    Robots stand on distinct points of the world's start grid, drawn at random, with headings uniform on the circle.
    `reset(options={"initial_poses": array})` with (num_robots, 3) x, y in m and heading in rad sets them instead.

    ## Episode End
    Truncated after 600 ticks (60 s); never terminated.

    ## Information
    `poses` (num_robots, 3) x and y in m, heading in rad; `time` in s.

    ## Arguments
    ```python
    gym.make("HeRo/Swarm-v0", world="hero_plus", num_robots=None, engine="chipmunk", render_mode=None, task=None,
             robot_software=None, controller=None)
    ```
    `world`: a name, the path of a YAML file, or a `WorldSpec`. `num_robots`: another number of robots than the world's. `engine`:
    `chipmunk` or `disc`. `render_mode`: `rgb_array` (513 x 426 pixels for `hero_plus`), `human` (a window that follows every tick;
    needs pygame) or None. `task`: a name, or a function that takes the `WorldSpec` and returns a reward function, which takes the poses
    before and after a tick, each (worlds, num_robots, 3), and returns (worlds,) rewards.
    `controller=[v0, omega0, v1, omega1]`: every robot drives itself by that controller, as in `swarm_envs.rollouts`; the action space is
    then `Discrete(1)`, one tick passes at each step. With `robot_software="firmware"` as well every robot runs its own C code with the
    controller on board, through a simulated servo, encoder and range sensor. `swarm_envs.policies.ControllerPolicy` maps observations
    to the same commands, to be passed to `step`.

    ## Version History
    - v0: first release.
    """

    metadata: dict[str, Any] = {  # noqa: RUF012  Gymnasium declares it so
        "render_modes": RENDER_MODES,
        "render_fps": RENDER_FPS,
    }

    def __init__(
        self,
        world: str | Path | WorldSpec = "hero_plus",
        num_robots: int | None = None,
        engine: str = "chipmunk",
        render_mode: str | None = None,
        task: str | Task | None = None,
        robot_software: str | None = None,
        controller: npt.ArrayLike | None = None,
    ) -> None:
        self._single_world = SingleWorld(world, num_robots, engine, render_mode, task, robot_software, controller)
        self.world = self._single_world.world
        self.render_mode = render_mode
        self.observation_space = swarm_observation_space(self.world)
        self.action_space = self._single_world.swarm_action_space()

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Observation, dict[str, Any]]:
        """Start an episode; see the class for ``options``."""
        super().reset(seed=seed)
        self._single_world.reset(self.np_random, options)
        return self._single_world.detections(), self._info()

    def step(self, action: npt.ArrayLike) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Run one tick of the world with the robots' commands."""
        self._single_world.advance(action)
        return self._single_world.detections(), self._single_world.reward, False, False, self._info()

    def render(self) -> npt.NDArray[np.uint8] | None:
        """Return the picture (height, width, 3) of the present moment; ``human`` shows it in the window instead and returns None."""
        return self._single_world.render()

    def close(self) -> None:
        """Close the window, if there is one."""
        self._single_world.close()

    def _info(self) -> dict[str, Any]:
        return {"poses": self._single_world.poses(), "time": self._single_world.time()}

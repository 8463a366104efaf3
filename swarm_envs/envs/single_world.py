"""What the Gymnasium and the PettingZoo adapter share: one running world, who drives its robots, pictures."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from swarm_envs.envs.interface import RENDER_FPS, check_render_mode, checked_actions, draw_key, swarm_action_space
from swarm_envs.envs.robot_software import make_robot_software
from swarm_envs.envs.tasks import Task, environment_name, make_rewards
from swarm_envs.rendering import Renderer
from swarm_envs.rendering.window import Window
from swarm_envs.simulation import Simulation
from swarm_envs.worlds import WorldSpec, load_world

TRAIL_SECONDS = 12.0
"""Length of the trails in pictures."""


class SingleWorld:
    """One world that an environment steps.

    Args:
        world: A world's name, file or spec.
        num_robots: Number of robots instead of the world's own.
        engine: ``chipmunk`` or ``disc``.
        render_mode: ``rgb_array``, ``human`` for a window that follows every tick, or None.
        task: What the swarm is rewarded for: a task, its name, or None.
        robot_software: ``actions`` when the agent commands the robots, ``controller`` when they carry one, ``firmware`` when they run
            their own code; None: ``controller`` where one is given, else ``actions``.
        controller: (4,) or (R, 4) [v0, omega0, v1, omega1] in m/s and rad/s of robots that drive themselves.

    Raises:
        ValueError: For an unknown world, engine, render mode, task or software; one line.
        ImportError: For a window without pygame; one line that says how to install it.
    """

    def __init__(
        self,
        world: str | Path | WorldSpec,
        num_robots: int | None,
        engine: str,
        render_mode: str | None,
        task: str | Task | None = None,
        robot_software: str | None = None,
        controller: npt.ArrayLike | None = None,
    ) -> None:
        self.world = load_world(world, num_robots=num_robots)
        self.render_mode = check_render_mode(render_mode)
        self.simulation = Simulation(self.world, 1, engine)
        self._rewards = make_rewards(task, self.world)
        self.reward = 0.0
        self.software = make_robot_software(self.simulation, robot_software, controller)
        self._trail: deque[npt.NDArray[np.float64]] = deque(maxlen=max(2, round(TRAIL_SECONDS / self.world.tick)))
        self._renderer: Renderer | None = None
        self._window = Window(environment_name(task), RENDER_FPS) if render_mode == "human" else None

    def swarm_action_space(self) -> spaces.Space[Any]:
        """The swarm's commands; one empty action for robots that drive themselves."""
        return swarm_action_space(self.world) if self.software is None else spaces.Discrete(1)

    def reset(self, generator: np.random.Generator, options: dict[str, Any] | None) -> None:
        """Start an episode with a key drawn from the environment's generator.

        Args:
            generator: The environment's ``np_random``.
            options: ``initial_poses`` (R, 3) in m, m, rad, or nothing; other keys are left to others, as PettingZoo's tests expect.

        Raises:
            ValueError: For poses that do not fit.
        """
        poses = (options or {}).get("initial_poses")
        self.simulation.reset(keys=draw_key(generator), initial_poses=None if poses is None else np.asarray(poses, np.float64)[None])
        if self.software is not None:
            self.software.reset()
        self._trail.clear()
        self._follow()

    def advance(self, actions: npt.ArrayLike) -> None:
        """Run one tick with actions (R, 2 or 3), clipped to the limits, or with those of the robots' own software.

        Raises:
            ValueError: For another shape, or a value that is not a finite number.
        """
        before = self.simulation.poses.copy()
        if self.software is not None:
            self.simulation.step(self.software.commands(self.simulation)[None])
        else:
            commands, messages = checked_actions(actions, (), self.world)
            self.simulation.step(commands[None], None if messages is None else messages[None])
        self.reward = float(self._rewards(before, self.simulation.poses)[0])
        self._follow()

    def detections(self) -> npt.NDArray[np.int8]:
        """Each robot's readings, (R,) or (R, S), as a copy."""
        return np.array(self.simulation.detections[0], dtype=np.int8)

    def poses(self) -> npt.NDArray[np.float64]:
        """Poses (R, 3) in m, m, rad, as a copy."""
        return np.array(self.simulation.poses[0])

    def time(self) -> float:
        """Seconds since the start."""
        return float(self.simulation.time[0])

    def render(self) -> npt.NDArray[np.uint8] | None:
        """The picture (H, W, 3) of the present moment; None without a render mode, and where a window shows it instead."""
        if self.render_mode is None:
            return None
        if self._window is None:
            return self._picture()
        self._window.show(self._picture())
        return None

    def close(self) -> None:
        """Close the window, if there is one."""
        if self._window is not None:
            self._window.close()

    def _picture(self) -> npt.NDArray[np.uint8]:
        if self._renderer is None:
            self._renderer = Renderer(self.world)
        return self._renderer(
            self.simulation.poses[0],
            self.simulation.detections[0],
            trail=np.stack(self._trail) if len(self._trail) > 1 else None,
            contacts=self.simulation.touching[0] > 0,
            object_poses=self.simulation.objects[0],
        )

    def _follow(self) -> None:
        """Lengthen the trails, and show the present moment where a window is open."""
        if self.render_mode is not None:
            self._trail.append(self.poses())
        if self._window is not None:
            self.render()

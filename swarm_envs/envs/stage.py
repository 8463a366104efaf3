"""What the Gymnasium and the PettingZoo shell share: one running world, its spaces' sizes, checked actions, pictures."""

from __future__ import annotations

from collections import deque
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from swarm_envs.envs.robot_software import make_robot_software
from swarm_envs.rendering import Renderer
from swarm_envs.simulation import Simulation
from swarm_envs.worlds import WorldSpec, load_world

RENDER_MODES = ["rgb_array"]
TRAIL_SECONDS = 12.0
"""Length of the trails in pictures."""


class Stage:
    """One world that an environment steps.

    Args:
        world: A world's name, file or spec.
        num_robots: Number of robots instead of the world's own.
        engine: ``chipmunk`` or ``disc``.
        render_mode: ``rgb_array`` or None.
        robot_software: ``actions`` when the agent commands the robots, ``firmware`` when they run their own code.
        controller: (4,) or (R, 4) the firmware's [v0, omega0, v1, omega1] in m/s and rad/s.

    Raises:
        ValueError: For an unknown world, engine, render mode or software; one line.
    """

    def __init__(
        self,
        world: str | Path | WorldSpec,
        num_robots: int | None,
        engine: str,
        render_mode: str | None,
        robot_software: str = "actions",
        controller: npt.ArrayLike | None = None,
    ) -> None:
        if render_mode is not None and render_mode not in RENDER_MODES:
            raise ValueError(f"render_mode is {render_mode!r}, expected 'rgb_array' or None; for a window use the HumanRendering wrapper")
        self.world = load_world(world, num_robots=num_robots)
        self.render_mode = render_mode
        self.simulation = Simulation(self.world, 1, engine)
        self.software = make_robot_software(self.simulation, robot_software, controller)
        limits = np.array([self.world.limits.linear_speed, self.world.limits.angular_speed])
        # float32 rounds 0.09 up: step back to the largest float32 inside the limit
        rounded = limits.astype(np.float32)
        self.limits = np.where(rounded > limits, np.nextafter(rounded, np.float32(0)), rounded)
        self._trail: deque[npt.NDArray[np.float64]] = deque(maxlen=max(2, round(TRAIL_SECONDS / self.world.tick)))
        self._renderer: Renderer | None = None

    def robot_action_space(self) -> spaces.Box:
        """(v in m/s, omega in rad/s) of one robot, bounded by the world's limits."""
        return spaces.Box(-self.limits, self.limits, dtype=np.float32)

    def swarm_action_space(self) -> spaces.Space[Any]:
        """(v in m/s, omega in rad/s) of every robot (R, 2), bounded by the world's limits; one empty action for self-driven robots."""
        if self.software is not None:
            return spaces.Discrete(1)
        high = np.repeat(self.limits[None, :], self.world.num_robots, axis=0)
        return spaces.Box(-high, high, dtype=np.float32)

    def reset(self, generator: np.random.Generator, options: dict[str, Any] | None) -> None:
        """Start anew with a key drawn from the environment's generator.

        Args:
            generator: The environment's ``np_random``.
            options: ``initial_poses`` (R, 3) in m, m, rad, or nothing; other keys are left to others, as PettingZoo's tests expect.

        Raises:
            ValueError: For poses that do not fit.
        """
        poses = (options or {}).get("initial_poses")
        key = generator.integers(0, 2**63, size=1, dtype=np.uint64)
        self.simulation.reset(keys=key, initial_poses=None if poses is None else np.asarray(poses, np.float64)[None])
        if self.software is not None:
            self.software.reset()
        self._trail.clear()
        self._remember()

    def advance(self, commands: npt.ArrayLike) -> None:
        """Run one tick with commands (R, 2), clipped to the limits, or with those of the robots' own software.

        Raises:
            ValueError: For another shape, or a value that is not a finite number.
        """
        if self.software is not None:
            self.simulation.step(self.software.commands(self.simulation)[None])
        else:
            self.simulation.step(self._checked(commands)[None])
        self._remember()

    def _checked(self, commands: npt.ArrayLike) -> npt.NDArray[np.float64]:
        array = np.asarray(commands, dtype=np.float64)
        expected = (self.world.num_robots, 2)
        if array.shape != expected:
            raise ValueError(f"action has shape {array.shape}, expected {expected}: v in m/s and omega in rad/s of each robot")
        if not np.isfinite(array).all():
            robot, column = np.argwhere(~np.isfinite(array))[0]
            raise ValueError(
                f"action of robot {robot} has {('v', 'omega')[column]} = {array[robot, column]}, expected a finite number; "
                "check the policy for NaN"
            )
        limits = self.world.limits
        bound = np.array([limits.linear_speed, limits.angular_speed])
        return np.clip(array, -bound, bound)

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
        """The picture (H, W, 3) of the present moment; None without a render mode."""
        if self.render_mode is None:
            return None
        if self._renderer is None:
            self._renderer = Renderer(self.world)
        return self._renderer(
            self.simulation.poses[0],
            self.simulation.detections[0],
            trail=np.stack(self._trail) if len(self._trail) > 1 else None,
            contacts=self.simulation.touching[0] > 0,
            object_poses=self.simulation.objects[0],
        )

    def _remember(self) -> None:
        if self.render_mode is not None:
            self._trail.append(self.poses())

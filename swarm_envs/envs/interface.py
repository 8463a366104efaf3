"""What every shell offers an agent: spaces, checked commands, the key of an episode."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from swarm_envs.worlds import WorldSpec

RENDER_MODES = ["rgb_array"]


def check_render_mode(render_mode: str | None) -> str | None:
    """Return the render mode.

    Raises:
        ValueError: For one that does not exist.
    """
    if render_mode not in (None, *RENDER_MODES):
        raise ValueError(f"render_mode is {render_mode!r}, expected 'rgb_array' or None; for a window use the HumanRendering wrapper")
    return render_mode


def command_limits(world: WorldSpec) -> npt.NDArray[np.float64]:
    """Return the greatest (v, omega) in m/s and rad/s."""
    return np.array([world.limits.linear_speed, world.limits.angular_speed])


def robot_action_space(world: WorldSpec) -> spaces.Box:
    """(v in m/s, omega in rad/s) of one robot, bounded by the world's limits."""
    high = _within(command_limits(world))
    return spaces.Box(-high, high, dtype=np.float32)


def swarm_action_space(world: WorldSpec) -> spaces.Box:
    """(v in m/s, omega in rad/s) of every robot (R, 2), bounded by the world's limits."""
    high = np.repeat(_within(command_limits(world))[None, :], world.num_robots, axis=0)
    return spaces.Box(-high, high, dtype=np.float32)


def robot_observation_space(world: WorldSpec) -> spaces.MultiBinary:
    """Readings of one robot (S,)."""
    return spaces.MultiBinary(world.num_sensors)


def swarm_observation_space(world: WorldSpec) -> spaces.MultiBinary:
    """Readings of every robot, (R,) with one sensor each, else (R, S)."""
    return spaces.MultiBinary(world.num_robots if world.num_sensors == 1 else [world.num_robots, world.num_sensors])


def checked_commands(commands: npt.ArrayLike, shape: tuple[int, ...], world: WorldSpec) -> npt.NDArray[np.float64]:
    """Return commands (..., R, 2) as float64, clipped to the world's limits.

    Raises:
        ValueError: For another shape, or a value that is not a finite number.
    """
    array = np.asarray(commands, dtype=np.float64)
    if array.shape != shape:
        raise ValueError(f"action has shape {array.shape}, expected {shape}: v in m/s and omega in rad/s of each robot")
    if not np.isfinite(array).all():
        *copy, robot, column = np.argwhere(~np.isfinite(array))[0]
        whose = f"robot {robot}" + (f" of copy {copy[0]}" if copy else "")
        value = array[(*copy, robot, column)]
        raise ValueError(f"action of {whose} has {('v', 'omega')[column]} = {value}, expected a finite number; check the policy for NaN")
    limits = command_limits(world)
    return np.clip(array, -limits, limits)


def draw_key(generator: np.random.Generator) -> npt.NDArray[np.uint64]:
    """Draw an episode's key (1,) from an environment's generator."""
    return generator.integers(0, 2**63, size=1, dtype=np.uint64)


def _within(limits: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """The largest float32 inside the limits: rounding alone may go beyond them."""
    rounded = limits.astype(np.float32)
    return np.where(rounded > limits, np.nextafter(rounded, np.float32(0)), rounded)

"""What every adapter offers an agent: spaces, checked commands, the key of an episode."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from gymnasium import spaces

from swarm_envs.worlds import WorldSpec

RENDER_MODES = ["human", "rgb_array"]
"""What an environment of one world can render: a window that follows every tick, or pictures on demand."""
RENDER_FPS = 10
"""Pictures per second of a window or a film: one for each tick of 0.1 s."""


def check_render_mode(render_mode: str | None, modes: Sequence[str] = RENDER_MODES) -> str | None:
    """Return the render mode.

    Raises:
        ValueError: For one that is none of ``modes``.
    """
    if render_mode not in (None, *modes):
        raise ValueError(f"render_mode is {render_mode!r}, expected {', '.join(map(repr, modes))} or None")
    return render_mode


def command_limits(world: WorldSpec) -> npt.NDArray[np.float64]:
    """Return the greatest (v, omega) in m/s and rad/s."""
    return np.array([world.limits.linear_speed, world.limits.angular_speed])


def robot_action_space(world: WorldSpec) -> spaces.Box:
    """(v in m/s, omega in rad/s) of one robot, bounded by the world's limits; with a broadcast a third number from 0 to 1."""
    high = _rounded_inside(command_limits(world))
    low = -high
    if world.broadcast is not None:
        low, high = np.append(low, np.float32(0)), np.append(high, np.float32(1))
    return spaces.Box(low, high, dtype=np.float32)


def swarm_action_space(world: WorldSpec) -> spaces.Box:
    """The rows of :func:`robot_action_space` for every robot, (R, 2) or (R, 3)."""
    one = robot_action_space(world)
    return spaces.Box(np.tile(one.low, (world.num_robots, 1)), np.tile(one.high, (world.num_robots, 1)), dtype=np.float32)


def robot_observation_space(world: WorldSpec) -> spaces.Box:
    """Readings of one robot (S,), 0 or 1: one per sensor, and with a broadcast whether it hears another.

    A box of integers, which PettingZoo's checks ask for, and which more trainers take than a multi-binary space.
    """
    return spaces.Box(0, 1, (world.num_readings,), dtype=np.int8)


def swarm_observation_space(world: WorldSpec) -> spaces.MultiBinary:
    """Readings of every robot, (R,) with one sensor each, else (R, S)."""
    return spaces.MultiBinary(world.num_robots if world.num_readings == 1 else [world.num_robots, world.num_readings])


def action_columns(world: WorldSpec) -> tuple[str, ...]:
    """What the numbers of a robot's action are."""
    return ("v", "omega") if world.broadcast is None else ("v", "omega", "message")


def checked_actions(
    actions: npt.ArrayLike, copies: tuple[int, ...], world: WorldSpec
) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_] | None]:
    """Return commands (*copies, R, 2) as float64, clipped to the world's limits, and messages (*copies, R) where there is a broadcast.

    Raises:
        ValueError: For another shape, or a value that is not a finite number.
    """
    array, columns = np.asarray(actions, dtype=np.float64), action_columns(world)
    shape = (*copies, world.num_robots, len(columns))
    if array.shape != shape:
        more = "" if world.broadcast is None else ", and a message that is sent above 0.5,"
        raise ValueError(f"action has shape {array.shape}, expected {shape}: v in m/s and omega in rad/s{more} of each robot")
    if not np.isfinite(array).all():
        *copy, robot, column = np.argwhere(~np.isfinite(array))[0]
        whose = f"robot {robot}" + (f" of copy {copy[0]}" if copy else "")
        value = array[(*copy, robot, column)]
        raise ValueError(f"action of {whose} has {columns[column]} = {value}, expected a finite number; check the policy for NaN")
    limits = command_limits(world)
    return np.clip(array[..., :2], -limits, limits), None if world.broadcast is None else array[..., 2] > 0.5


def draw_key(generator: np.random.Generator) -> npt.NDArray[np.uint64]:
    """Draw an episode's key (1,) from an environment's generator."""
    return generator.integers(0, 2**63, size=1, dtype=np.uint64)


def _rounded_inside(limits: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
    """The largest float32 inside the limits: rounding alone may go beyond them."""
    rounded = limits.astype(np.float32)
    return np.where(rounded > limits, np.nextafter(rounded, np.float32(0)), rounded)

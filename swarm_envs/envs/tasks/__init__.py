"""Tasks: what a swarm is rewarded for, one behaviour of the paper per file.

A task is a function of a world that returns a reward function. That one takes the poses of W worlds before and after a tick, each
(W, R, 3) in m, m, rad, and returns W rewards; the environments call it after every tick and give every robot of a swarm the same. Each
task here rewards with numbers from 0 to 1, every tick, and is greatest where the behaviour is complete. The functions are compiled, one
loop over worlds, so that a world's reward has the same bits alone and among a thousand.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from swarm_envs.envs.tasks.aggregation import aggregation
from swarm_envs.envs.tasks.cyclic_pursuit import cyclic_pursuit
from swarm_envs.envs.tasks.dispersal import dispersal
from swarm_envs.envs.tasks.milling import milling
from swarm_envs.envs.tasks.wall_following import wall_following
from swarm_envs.worlds import WorldError, WorldSpec

__all__ = [
    "TASKS",
    "RewardFunction",
    "Task",
    "aggregation",
    "cyclic_pursuit",
    "dispersal",
    "environment_name",
    "make_rewards",
    "milling",
    "wall_following",
]

FloatArray = npt.NDArray[np.float64]
RewardFunction = Callable[[FloatArray, FloatArray], FloatArray]
"""(poses before, poses after), each (W, R, 3) -> rewards (W,)."""
Task = Callable[[WorldSpec], RewardFunction]

TASKS: dict[str, Task] = {
    "Aggregation": aggregation,
    "CyclicPursuit": cyclic_pursuit,
    "Dispersal": dispersal,
    "Milling": milling,
    "WallFollowing": wall_following,
}
"""The tasks with an environment id of their own: ``HeRo/<name>-v0``."""


def environment_name(task: str | Task | None) -> str:
    """Return the id of the environment with a task: that of the swarm without one where the task has no id of its own."""
    return f"HeRo/{task}-v0" if isinstance(task, str) else "HeRo/Swarm-v0"


def make_rewards(task: str | Task | None, world: WorldSpec) -> RewardFunction:
    """Return the reward function of a task in a world: by name, by function, or zero for None.

    Raises:
        WorldError: For an unknown name.
    """
    if task is None:
        return no_reward
    if isinstance(task, str):
        if task not in TASKS:
            raise WorldError(f"task is {task!r}, expected one of {', '.join(TASKS)}, a function of a world, or None")
        task = TASKS[task]
    return task(world)


def no_reward(before: FloatArray, after: FloatArray) -> FloatArray:
    """Zero, where there is no task."""
    return np.zeros(len(after))

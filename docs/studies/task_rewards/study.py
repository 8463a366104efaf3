"""The table of ``docs/guides/training.md``: what each task pays its own behaviour, and random controllers.

``make study-task_rewards`` or ``python -m docs.studies.task_rewards`` prints it: means over whole runs of 1,200 uniform controllers in
`unrefined`, where the paper found all five behaviours. Labels are given by rules.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from swarm_envs import behaviours, load_world, rollouts
from swarm_envs.envs.tasks import TASKS, make_rewards

LABELS = {
    "Aggregation": "aggregation",
    "CyclicPursuit": "cyclic pursuit",
    "Dispersal": "dispersal",
    "Milling": "milling",
    "WallFollowing": "wall following",
}


def main(given: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.task_rewards", description=__doc__.partition("\n")[0])
    parser.add_argument("--controllers", type=int, default=1200, help="random controllers (default %(default)s)")
    controllers = parser.parse_args(given).controllers
    world = load_world("unrefined")
    limits = np.array([world.limits.linear_speed, world.limits.angular_speed] * 2)
    runs = rollouts(world, np.random.default_rng(11).uniform(-1, 1, (controllers, 4)) * limits, seed=3)
    labels = np.array(behaviours.label(runs))
    frames = [np.ascontiguousarray(runs.poses[:, k]) for k in range(len(runs.time))]
    print("| id | runs with the label | mean reward of its behaviour | of random controllers |\n|---|---|---|---|")
    for task in TASKS:
        reward = make_rewards(task, world)
        mean = np.mean([reward(*pair) for pair in pairwise(frames)], axis=0)
        own = labels == LABELS[task]
        print(f"| `HeRo/{task}-v0` | {own.sum()} | {mean[own].mean():.2f} | {mean.mean():.2f} |")

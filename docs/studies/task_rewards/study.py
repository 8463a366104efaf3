"""What does each task pay its own behaviour, and random controllers?

``make study-task_rewards`` or ``python -m docs.studies.task_rewards`` writes the table of the page: means over whole runs of uniform
controllers in the world `unrefined`. Labels are given by rules.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from docs.studies.marked_page import write_between_marks
from swarm_envs import behaviours, load_world, rollouts
from swarm_envs.envs.tasks import TASKS, make_rewards

PAGE = Path(__file__).with_name("index.md")
CONTROLLERS = 1200
"""Drawn uniformly within the world's limits."""
LABELS = {
    "Aggregation": "aggregation",
    "CyclicPursuit": "cyclic pursuit",
    "Dispersal": "dispersal",
    "Milling": "milling",
    "WallFollowing": "wall following",
}


def table(controllers: int) -> str:
    """Return the mean rewards of the runs with a task's own label, and of all, as Markdown."""
    world = load_world("unrefined")
    limits = np.array([world.limits.linear_speed, world.limits.angular_speed] * 2)
    runs = rollouts(world, np.random.default_rng(11).uniform(-1, 1, (controllers, 4)) * limits, seed=3)
    labels = np.array(behaviours.label(runs))
    frames = [np.ascontiguousarray(runs.poses[:, k]) for k in range(len(runs.time))]
    lines = ["| id | runs with its label | mean reward of these | of all |", "|---|---|---|---|"]
    for task in TASKS:
        reward = make_rewards(task, world)
        mean = np.mean([reward(*pair) for pair in pairwise(frames)], axis=0)
        own = labels == LABELS[task]
        paid = f"{mean[own].mean():.2f}" if own.any() else ""
        lines.append(f"| `HeRo/{task}-v0` | {own.sum()} | {paid} | {mean.mean():.2f} |")
    return "\n".join(lines)


def main(given: Sequence[str] | None = None) -> None:
    """Run the study."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.task_rewards", description=__doc__.partition("\n")[0])
    parser.add_argument("--controllers", type=int, default=CONTROLLERS, help="random controllers (default %(default)s)")
    parser.add_argument("--print", action="store_true", help="print the table, write nothing")
    arguments = parser.parse_args(given)
    found = table(arguments.controllers)
    if arguments.print:
        print(found)
    else:
        write_between_marks(PAGE, {"results": found})

"""Fifty runs of the Python simulation that the playground is held to; ``python -m tests.docs.golden`` writes them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

import swarm_envs
from docs.site.generate import PRESETS
from swarm_envs import behaviours

PATH = Path(__file__).with_name("golden.json")
SEEDS = {"hero_plus": (1, 2, 3, 4), "unrefined": (1, 2, 3)}
"""Starts of each named controller: 12 runs of three in hero_plus, 15 of five in unrefined."""
DRAWN = {"hero_plus": 12, "unrefined": 11}
"""Controllers drawn uniformly from a world's limits, whatever they show."""


def runs() -> list[dict[str, Any]]:
    """Return world, controller, start and Python's label (engine ``chipmunk``) of the fifty runs."""
    generator = np.random.default_rng(8)
    jobs = [(preset["world"], preset["controller"], seed) for preset in PRESETS for seed in SEEDS[preset["world"]]]
    for world, count in DRAWN.items():
        limits = swarm_envs.load_world(world).limits
        high = np.tile([limits.linear_speed, limits.angular_speed], 2)
        jobs += [(world, generator.uniform(-high, high).round(3).tolist(), 100 + k) for k in range(count)]
    golden = []
    for world, controller, seed in jobs:
        starts = swarm_envs.rollouts(world, [controller], seed=seed, steps=0, threads=1).poses[:, 0].round(6)
        run = swarm_envs.rollouts(world, [controller], initial_poses=starts, engine="chipmunk", threads=1)
        golden.append({"world": world, "controller": controller, "poses": starts[0].tolist(), "label": behaviours.label(run)[0]})
    return golden


if __name__ == "__main__":
    PATH.write_text("[\n" + ",\n".join(json.dumps(run) for run in runs()) + "\n]\n")

"""Logs that the simulation itself makes: what a world that has the right effects predicts to the last reading."""

from __future__ import annotations

import numpy as np

from swarm_envs import WorldSpec, rollouts
from swarm_envs.calibration import Log, Track

CONTROLLERS = np.array([[0.08, 0.6, 0.05, -1.2], [0.06, -0.8, 0.09, 0.3], [-0.07, 0.5, 0.08, 1.0], [0.09, 1.1, -0.06, 0.4]])
"""[v0, omega0, v1, omega1] of each run."""


def log_of(world: WorldSpec, steps: int = 200) -> Log:
    """A log of whole swarms, without noise."""
    runs = rollouts(world, CONTROLLERS, steps=steps, seed=4)
    tracks = []
    for w, i in np.ndindex(len(runs), world.num_robots):
        seen = runs.detections[w, :, i] > 0
        tracks.append(Track(f"run_{w}", f"robot_{i}", runs.time, runs.poses[w, :, i], runs.time, runs.commands[w, :, i], runs.time, seen))
    return Log("swarms", tuple(tracks), outline=world.arena.outline)

"""The test set: labelled rollouts of random controllers that no training has seen (paper, 500 labelled test videos)."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from discovery.controllers import random_controllers
from discovery.errors import DiscoveryError
from discovery.progress import bar
from discovery.randomness import generator, whole_seed
from discovery.representations.interface import Representation
from discovery.simulate import Simulator
from swarm_envs.behaviours import label
from swarm_envs.simulation import Trajectories

CHUNK = 250
"""Rollouts simulated at a time."""
FEWEST = 10
"""A behaviour with fewer rollouts is left out."""


@dataclass(frozen=True)
class TestSet:
    """Labelled rollouts; their labels are given by rules."""

    __test__ = False
    """pytest: this is no test."""

    parts: tuple[Trajectories, ...]
    labels: npt.NDArray[np.str_]
    """(N,) in the order of the parts."""

    @property
    def classes(self) -> list[str]:
        """Behaviours that occur, by name."""
        return sorted(set(self.labels.tolist()))

    def embed(self, representation: Representation) -> npt.NDArray[np.float32]:
        """Embed every rollout: (N, d)."""
        return np.concatenate([representation.embed(part) for part in self.parts])


def draw_test_set(simulator: Simulator, a_class: int, most_draws: int, seed: int) -> TestSet:
    """Draw random controllers until every behaviour has enough rollouts, or the draws are used up.

    Args:
        simulator: World, engine and length.
        a_class: Rollouts wanted of each behaviour.
        most_draws: Rollouts simulated at most.
        seed: Of controllers and starts; no dataset has them, whatever its seed.

    Raises:
        DiscoveryError: When fewer than two behaviours have enough.
    """
    parts: list[Trajectories] = []
    labels: list[str] = []
    counts: Counter[str] = Counter()
    with bar(most_draws, "test set", "rollouts") as progress:
        for number in range(-(-most_draws // CHUNK)):
            controllers = random_controllers(simulator.world, CHUNK, generator(seed, "test controllers", number))
            trajectories = simulator(controllers, whole_seed(seed, "test starts", number))
            kept = []
            for index, name in enumerate(label(trajectories)):
                if counts[name] < a_class:
                    counts[name] += 1
                    kept.append(index)
                    labels.append(name)
            if kept:
                parts.append(trajectories[np.array(kept)])
            progress.update(CHUNK)
            if len(counts) > 1 and all(count >= a_class for count in counts.values()) and number >= 3:
                break
    names = np.array(labels, dtype=np.str_)
    rare = [name for name, count in counts.items() if count < FEWEST]
    keep = ~np.isin(names, rare)
    begin, whole = 0, []
    for part in parts:
        inside = keep[begin : begin + len(part.poses)]
        begin += len(part.poses)
        if inside.any():
            whole.append(part[np.flatnonzero(inside)])
    found = TestSet(tuple(whole), names[keep])
    if len(found.classes) < 2:
        raise DiscoveryError(f"test set: {dict(counts)} of {most_draws} rollouts; expected two behaviours of {FEWEST} or more, draw more")
    return found

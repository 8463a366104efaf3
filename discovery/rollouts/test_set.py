"""The test set: labelled rollouts of random controllers that no training has seen (paper, 500 labelled test videos)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from discovery.controllers import random_controllers
from discovery.errors import DiscoveryError
from discovery.progress import bar
from discovery.randomness import generator, whole_seed
from discovery.rollouts.filming import fingerprint
from discovery.rollouts.simulator import Simulator
from swarm_envs.behaviours import label
from swarm_envs.rendering import videos
from swarm_envs.simulation import Trajectories

CHUNK = 250
"""Rollouts simulated at a time."""
FEWEST = 10
"""A behaviour with fewer rollouts is left out."""
CLASSES = 5
"""The whole set is to be this many times what is wanted of a class (500 of 100 each): what rare behaviours lack the others fill up."""


@dataclass(frozen=True)
class LabelledTestSet:
    """Labelled rollouts."""

    parts: tuple[Trajectories, ...]
    labels: npt.NDArray[np.str_]
    """(N,) in the order of the parts."""
    given_by: str = "rules"
    """Who gave the labels."""

    @property
    def classes(self) -> list[str]:
        """Behaviours that occur, by name."""
        return sorted(set(self.labels.tolist()))

    @property
    def fingerprint(self) -> str:
        """What the rollouts are known by, whoever labels them."""
        return fingerprint(np.concatenate([videos(part) for part in self.parts]))

    def relabelled(self, labels: Mapping[int, str], given_by: str) -> LabelledTestSet:
        """Return the rollouts that a person has labelled, with those labels.

        Raises:
            DiscoveryError: When fewer than two behaviours have enough of them.
        """
        counts = Counter(labels.values())
        names = np.array([labels.get(row, "") for row in range(len(self.labels))], dtype=np.str_)
        found = self._where(np.isin(names, [name for name, count in counts.items() if count >= FEWEST]), names, given_by)
        if len(found.classes) < 2:
            raise DiscoveryError(f"labels of {given_by}: {dict(counts)}; expected two behaviours of {FEWEST} or more, label more")
        return found

    def _where(self, keep: npt.NDArray[np.bool_], names: npt.NDArray[np.str_], given_by: str) -> LabelledTestSet:
        ends = np.cumsum([len(part.poses) for part in self.parts])
        inside = [np.flatnonzero(chosen) for chosen in np.split(keep, ends[:-1])]
        return LabelledTestSet(tuple(part[rows] for part, rows in zip(self.parts, inside, strict=True) if len(rows)), names[keep], given_by)


def draw_test_set(simulator: Simulator, per_class: int, most_draws: int, seed: int) -> LabelledTestSet:
    """Draw random controllers until every behaviour has enough rollouts, or the draws are used up.

    Where some behaviours are too rare, more of the others are taken, as evenly as can be, until there are five times ``per_class`` in all.

    Args:
        simulator: World, engine and length.
        per_class: Rollouts wanted of each behaviour.
        most_draws: Rollouts simulated at most.
        seed: Of controllers and starts; no dataset has them, whatever its seed.

    Raises:
        DiscoveryError: When fewer than two behaviours have enough.
    """
    parts: list[Trajectories] = []
    labels: list[str] = []
    counts: Counter[str] = Counter()
    most = per_class * CLASSES // 2  # of one behaviour, when there are but two
    with bar(most_draws, "test set", "rollouts") as progress:
        for number in range(-(-most_draws // CHUNK)):
            controllers = random_controllers(simulator.world, CHUNK, generator(seed, "test controllers", number))
            trajectories = simulator(controllers, whole_seed(seed, "test starts", number))
            kept = []
            for index, name in enumerate(label(trajectories)):
                if counts[name] < most:
                    counts[name] += 1
                    kept.append(index)
                    labels.append(name)
            if kept:
                parts.append(trajectories[np.array(kept)])
            progress.update(CHUNK)
            if len(counts) >= CLASSES and all(count >= per_class for count in counts.values()) and number >= 3:
                break
    enough = {name: count for name, count in counts.items() if count >= FEWEST}
    if len(enough) < 2:
        raise DiscoveryError(f"test set: {dict(counts)} of {most_draws} rollouts; expected two behaviours of {FEWEST} or more, draw more")
    names = np.array(labels, dtype=np.str_)
    return LabelledTestSet(tuple(parts), names)._where(_first(names, shares(enough, per_class)), names, "rules")


def shares(counts: Mapping[str, int], per_class: int) -> dict[str, int]:
    """Return how many rollouts to take of each behaviour: ``per_class``, and where some have fewer, more of the others.

    Args:
        counts: Rollouts that there are of each.
        per_class: Rollouts wanted of each.
    """
    taken = {name: min(count, per_class) for name, count in counts.items()}
    while sum(taken.values()) < CLASSES * per_class:
        more = [name for name in sorted(counts) if taken[name] < counts[name]]
        if not more:
            break
        least = min(more, key=lambda name: taken[name])
        taken[least] += 1
    return taken


def _first(names: npt.NDArray[np.str_], wanted: Mapping[str, int]) -> npt.NDArray[np.bool_]:
    """Mark the first few rows of each name."""
    keep = np.zeros(len(names), dtype=np.bool_)
    for name, count in wanted.items():
        keep[np.flatnonzero(names == name)[:count]] = True
    return keep

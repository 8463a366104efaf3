"""Would the other engine say the same? Each medoid's controller is run again with both engines."""

from __future__ import annotations

import dataclasses
from collections import Counter
from dataclasses import dataclass
from typing import Any

import numpy as np

from discovery.controllers import FloatArray
from discovery.randomness import whole_seed
from discovery.rollouts.simulator import Simulator
from swarm_envs import behaviours
from swarm_envs.simulation.simulation import ENGINES, check_engine
from swarm_envs.worlds import WorldError

STARTS = 5
"""Starts that a controller is run from with each engine, the same for both; odd, so that two labels cannot share them evenly."""


@dataclass(frozen=True)
class Confirmation:
    """What both engines make of one controller."""

    engine: str
    """The other engine, which confirms or not."""
    label: str
    """What most runs with the run's own engine are called."""
    other_label: str
    """What most runs with the other engine are called."""
    votes: int
    """Runs with the other engine that were called so."""
    reason: str = ""
    """Why the other engine was not asked."""

    @property
    def confirmed(self) -> bool | None:
        """Whether both engines' majorities have one name; None when the other engine was not asked."""
        return None if self.reason else self.label == self.other_label

    def summary(self) -> dict[str, Any]:
        """What ``metrics.json`` says of it."""
        if self.reason:
            return {"engine": self.engine, "confirmed": None, "not_checked": self.reason}
        return {
            "engine": self.engine, "confirmed": self.confirmed, "starts": STARTS, "label_by_majority": self.label,
            "other_label_by_majority": self.other_label, "other_votes": self.votes,
        }  # fmt: skip


def confirm(simulator: Simulator, controllers: FloatArray, labels: list[str], seed: int) -> list[Confirmation]:
    """Run controllers (k, 4) from a few new starts with both engines.

    Args:
        simulator: The run's world and engine.
        controllers: (k, 4) the medoids'.
        labels: The k labels that the run gave them; they decide between labels with equally many votes.
        seed: The run's seed.

    Returns:
        One confirmation for each controller. A world that the other engine refuses leaves them unchecked, with its reason.
    """
    other = next(engine for engine in ENGINES if engine != simulator.engine)
    try:
        check_engine(simulator.world, other)
    except WorldError as error:
        return [Confirmation(other, label, "", 0, str(error)) for label in labels]
    runs = np.repeat(controllers, STARTS, axis=0)
    ours, theirs = (
        np.array(behaviours.label(each(runs, whole_seed(seed, "confirmation")))).reshape(-1, STARTS).tolist()
        for each in (simulator, dataclasses.replace(simulator, engine=other))
    )
    found = []
    for label, own, others in zip(labels, ours, theirs, strict=True):
        other_label = majority(others, label)
        found.append(Confirmation(other, majority(own, label), other_label, others.count(other_label)))
    return found


def majority(labels: list[str], favoured: str) -> str:
    """The label with most votes; of several, the favoured one, else the first in alphabetical order."""
    votes = Counter(labels)
    leaders = sorted(name for name, count in votes.items() if count == max(votes.values()))
    return favoured if favoured in leaders else leaders[0]


def describe(confirmations: list[Confirmation]) -> str:
    """How many the other engine confirms, in words."""
    if not confirmations:
        return "none to confirm"
    engine, reason = confirmations[0].engine, confirmations[0].reason
    if reason:
        return f"not checked with {engine}: {reason}"
    return f"{sum(bool(each.confirmed) for each in confirmations)} of {len(confirmations)} confirmed by {engine}"

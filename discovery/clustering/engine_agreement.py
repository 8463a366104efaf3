"""Does a medoid's label come back from new starts, and do both engines agree on what its controller does?

The two are told apart. A label is given to one rollout: from other starts the same controller may do something else, in both engines alike.
Then the engines agree, and the label does not repeat.
"""

from __future__ import annotations

import dataclasses
from collections import Counter
from collections.abc import Mapping
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
class EngineAgreement:
    """What both engines make of one controller from new starts."""

    label: str
    """What the medoid is called: the label of its one rollout in the archive."""
    repeated: int
    """Runs with the run's own engine, of :data:`STARTS`, that were called so again."""
    own_label: str
    """What most runs with the run's own engine are called."""
    engine: str
    """The other engine."""
    other_label: str = ""
    """What most runs with the other engine are called."""
    votes: int = 0
    """Runs with the other engine that were called so."""
    reason: str = ""
    """Why the other engine was not asked."""

    @property
    def agree(self) -> bool | None:
        """Whether both engines' majorities have one name, whatever the medoid is called; None when the other engine was not asked."""
        return None if self.reason else self.own_label == self.other_label

    @property
    def repeats(self) -> bool:
        """Whether most runs with the run's own engine have the medoid's label."""
        return self.own_label == self.label

    def summary(self) -> dict[str, Any]:
        """What ``metrics.json`` says of it."""
        asked: dict[str, Any] = {"other_label_by_majority": self.other_label, "other_votes": self.votes}
        return {
            "label_repeatability": {"starts": STARTS, "repeated": self.repeated, "label_by_majority": self.own_label},
            "engine_agreement": {
                "engine": self.engine, "agree": self.agree, **({"not_checked": self.reason} if self.reason else asked),
            },
        }  # fmt: skip


def engines_agree(medoid: Mapping[str, Any]) -> bool | None:
    """Return whether the engines agree on a medoid, as ``metrics.json`` has it; runs of an earlier version call it confirmed."""
    told = medoid["engine_agreement"]["agree"] if "engine_agreement" in medoid else medoid["confirmation"]["confirmed"]
    return None if told is None else bool(told)


def compare_engines(simulator: Simulator, controllers: FloatArray, labels: list[str], seed: int) -> list[EngineAgreement]:
    """Run controllers (k, 4) from a few new starts with both engines.

    Args:
        simulator: The run's world and engine.
        controllers: (k, 4) the medoids'.
        labels: The k labels that the run gave them; they decide between labels with equally many votes.
        seed: The run's seed.

    Returns:
        One for each controller. A world that the other engine refuses leaves it unasked, with its reason.
    """
    other, reason = next(engine for engine in ENGINES if engine != simulator.engine), ""
    try:
        check_engine(simulator.world, other)
    except WorldError as error:
        reason = str(error)
    ours = _labels(simulator, controllers, seed)
    theirs = ours if reason else _labels(dataclasses.replace(simulator, engine=other), controllers, seed)
    found = []
    for label, own, others in zip(labels, ours, theirs, strict=True):
        agreement = EngineAgreement(label, own.count(label), majority(own, label), other, reason=reason)
        if not reason:
            other_label = majority(others, label)
            agreement = dataclasses.replace(agreement, other_label=other_label, votes=others.count(other_label))
        found.append(agreement)
    return found


def _labels(simulator: Simulator, controllers: FloatArray, seed: int) -> list[list[str]]:
    """Return the labels of each controller (k, 4) from the new starts."""
    starts = whole_seed(seed, "confirmation")  # what the draws are keyed by is the name of an earlier version, so that they stay
    runs = simulator(np.repeat(controllers, STARTS, axis=0), starts)
    found: list[list[str]] = np.array(behaviours.label(runs)).reshape(-1, STARTS).tolist()
    return found


def majority(labels: list[str], favoured: str) -> str:
    """The label with most votes; of several, the favoured one, else the first in alphabetical order."""
    votes = Counter(labels)
    leaders = sorted(name for name, count in votes.items() if count == max(votes.values()))
    return favoured if favoured in leaders else leaders[0]


def describe(agreements: list[EngineAgreement]) -> str:
    """How many labels repeat and on how many medoids the engines agree, in words."""
    if not agreements:
        return "no medoids"
    count, engine, reason = len(agreements), agreements[0].engine, agreements[0].reason
    repeat = f"{sum(each.repeats for each in agreements)} of {count} labels repeat from most new starts"
    agree = f"{engine} not asked: {reason}" if reason else f"{engine} agrees on {sum(bool(each.agree) for each in agreements)} of {count}"
    return f"{repeat}; {agree}"

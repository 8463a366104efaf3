"""A bad network on simulated time, by its seed: it loses, delays, reorders, duplicates, holds back and records datagrams."""

from __future__ import annotations

import random
from collections.abc import Callable
from dataclasses import dataclass, field, replace

LATENCY = 0.001
"""Time on the way under any conditions, s."""


@dataclass(frozen=True)
class NetworkConditions:
    """What the network does to each datagram, in both directions."""

    loss: float = 0.0
    """Probability that it is lost."""
    delay: float = 0.0
    """Time on the way, s, on top of the latency."""
    jitter: float = 0.001
    """Uniform time on top, s: more than the time between datagrams reorders them."""
    duplication: float = 0.0
    """Probability that it arrives twice."""
    cut: bool = False
    held: bool = False
    """Held back, to be let go later."""


CUT = NetworkConditions(cut=True)

CONDITIONS = {
    "no impairment": NetworkConditions(),
    "30 % loss": NetworkConditions(loss=0.3),
    "reordering": NetworkConditions(jitter=0.08),
    "100 ms delay": NetworkConditions(delay=0.1),
    "loss, delay and reordering": NetworkConditions(loss=0.3, delay=0.02, jitter=0.06),
    "everything twice": NetworkConditions(delay=0.02, jitter=0.05, duplication=1.0),
}


@dataclass
class LossyNetwork:
    """Carries datagrams between a server and its robots.

    Args:
        seed: Of its losses and delays.
        schedule: Calls a function so many seconds later.
    """

    seed: int
    schedule: Callable[[float, Callable[[], object]], None]
    conditions: NetworkConditions = field(default_factory=NetworkConditions)
    recorded: list[tuple[int, bytes]] = field(default_factory=list)
    """All that servers have sent: to which robot, and what."""

    def __post_init__(self) -> None:
        self._random = random.Random(self.seed)
        self._held: list[Callable[[], object]] = []

    def carry(self, deliver: Callable[[], object]) -> None:
        """Take a datagram on its way; ``deliver`` hands it over."""
        conditions = self.conditions
        if conditions.cut or self._random.random() < conditions.loss:
            return
        if conditions.held:
            self._held.append(deliver)
            return
        for _ in range(2 if self._random.random() < conditions.duplication else 1):
            self.schedule(LATENCY + conditions.delay + self._random.uniform(0, conditions.jitter), lambda: self._arrive(deliver))

    def _arrive(self, deliver: Callable[[], object]) -> None:
        if not self.conditions.cut:
            deliver()

    def change(self, **changes: float | bool) -> None:
        """Change some of the conditions."""
        self.conditions = replace(self.conditions, **changes)  # type: ignore[arg-type]

    def release(self) -> int:
        """Deliver all that was held back, in order; how many there were."""
        held, self._held = self._held, []
        for place, deliver in enumerate(held):
            self.schedule(LATENCY + place * 1e-6, deliver)
        return len(held)

"""What every representation is: from rollouts to embeddings."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import numpy.typing as npt

from swarm_envs.simulation import Trajectories


class Representation(Protocol):
    """What the search needs."""

    @property
    def dimension(self) -> int:
        """Numbers in an embedding."""

    def embed(self, trajectories: Trajectories) -> npt.NDArray[np.float32]:
        """Embed each rollout: (W, dimension)."""


def embed_parts(representation: Representation, parts: Iterable[Trajectories]) -> npt.NDArray[np.float32]:
    """Embed rollouts that come in parts, at least one: (N, dimension)."""
    return np.concatenate([representation.embed(part) for part in parts])


@dataclass(frozen=True)
class Fitted:
    """A representation and how it came about."""

    representation: Representation
    origin: str
    """What it is or started from, in words for the report."""
    losses: list[float] = field(default_factory=list)
    """Training loss, one per step; empty when nothing was trained."""
    loss_name: str = "loss"
    """What the loss is, with its unit."""
    done: str = "nothing to train"
    """What was done, for the command's line."""

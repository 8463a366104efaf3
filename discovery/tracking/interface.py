"""What a tracker is told while a run goes on."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np
import numpy.typing as npt


class Tracker(Protocol):
    """Shows people the progress of a run.

    A stage is logged from its first step in every session that works on it: what was done before is known from the run folder. A tracker
    keeps one entry for each step all the same.
    """

    def begin(self, stage: str) -> None:
        """Expect the whole of a stage, from its first step on."""

    def log(self, stage: str, step: int, numbers: Mapping[str, float]) -> None:
        """Take the numbers of one step; steps come in order."""

    def picture(self, stage: str, name: str, image: npt.NDArray[np.uint8]) -> None:
        """Take a picture (height, width, 3)."""

    def flush(self) -> None:
        """Write what was taken so far: a run that is stopped after this does not log it again."""

    def close(self) -> None:
        """Write everything."""


class NullTracker:
    """Shows nothing: ``tracker=none``."""

    def begin(self, stage: str) -> None:
        """Ignore it."""

    def log(self, stage: str, step: int, numbers: Mapping[str, float]) -> None:
        """Ignore them."""

    def picture(self, stage: str, name: str, image: npt.NDArray[np.uint8]) -> None:
        """Ignore it."""

    def flush(self) -> None:
        """Do nothing."""

    def close(self) -> None:
        """Do nothing."""

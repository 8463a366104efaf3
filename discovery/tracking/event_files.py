"""TensorBoard's event files, in the run folder: ``tensorboard --logdir runs`` shows every run."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from torch.utils.tensorboard import SummaryWriter

FOLDER = "tensorboard"
"""Folder in the run folder, with one folder for each stage."""


class EventFiles:
    """Writes each stage's events into a folder of its own, and writes them again when a resumed run logs the stage again."""

    def __init__(self, path: Path) -> None:
        self._path = path / FOLDER
        self._writers: dict[str, SummaryWriter] = {}

    def begin(self, stage: str) -> None:
        """Remove the events of a stage that was logged in part."""
        from torch.utils.tensorboard import SummaryWriter  # torch takes seconds to import: only a run that goes on needs it

        if stage in self._writers:
            self._writers.pop(stage).close()
        for old in (self._path / stage).glob("events.out.tfevents.*"):
            old.unlink()
        self._writers[stage] = SummaryWriter(str(self._path / stage))

    def log(self, stage: str, step: int, numbers: Mapping[str, float]) -> None:
        """Write the numbers of one step."""
        for name, number in numbers.items():
            self._writers[stage].add_scalar(name, number, step)

    def picture(self, stage: str, name: str, image: npt.NDArray[np.uint8]) -> None:
        """Write a picture (height, width, 3)."""
        self._writers[stage].add_image(name, image, dataformats="HWC")

    def flush(self) -> None:
        """Write what was taken so far."""
        for writer in self._writers.values():
            writer.flush()

    def close(self) -> None:
        """Write everything."""
        for writer in self._writers.values():
            writer.close()
        self._writers.clear()

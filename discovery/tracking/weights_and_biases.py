"""Weights & Biases: ``tracker=wandb``."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from discovery.files.atomic import write_atomically
from discovery.tracking.run_name import run_name

MARKS = "tracker-steps.json"
"""File of the run folder with the last step sent of each stage."""


class WeightsAndBiases:
    """Logs to a wandb run that a resumed run goes on with; steps that it has already are not sent again."""

    def __init__(self, path: Path, project: str, settings: dict[str, Any]) -> None:
        import wandb

        self._wandb = wandb
        self._run = wandb.init(project=project, id=run_name(path, "wandb"), name=path.name, dir=str(path), config=settings, resume="allow")
        self._marks = path / MARKS
        self._done: dict[str, int] = {}

    def begin(self, stage: str) -> None:
        """Find out which steps are there already: wandb knows where it is online, the run folder where it is not."""
        self._run.define_metric(f"{stage}/step")
        self._run.define_metric(f"{stage}/*", step_metric=f"{stage}/step")
        try:
            marked = int(json.loads(self._marks.read_text(encoding="utf-8")).get(stage, -1))
        except (OSError, ValueError, AttributeError, TypeError):
            marked = -1  # the file helps where it can
        self._done[stage] = max(marked, int(self._run.summary.get(f"{stage}/step", -1)))

    def log(self, stage: str, step: int, numbers: Mapping[str, float]) -> None:
        """Send the numbers of a step that is new."""
        if step > self._done[stage]:
            self._run.log({f"{stage}/step": step} | {f"{stage}/{name}": number for name, number in numbers.items()})
            self._done[stage] = step

    def picture(self, stage: str, name: str, image: npt.NDArray[np.uint8]) -> None:
        """Send a picture (height, width, 3); it takes the place of an earlier one in the run's summary."""
        self._run.summary[f"{stage}/{name}"] = self._wandb.Image(image)

    def flush(self) -> None:
        """Mark how far it is; wandb writes by itself."""
        write_atomically(self._marks, json.dumps(self._done) + "\n")

    def close(self) -> None:
        """Send everything."""
        self.flush()
        self._run.finish()

"""Weights & Biases: ``tracker=wandb``."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from discovery.tracking.run_name import run_name


class WeightsAndBiases:
    """Logs to a wandb run that a resumed run goes on with; steps that it has already are not sent again."""

    def __init__(self, path: Path, project: str, settings: dict[str, Any]) -> None:
        import wandb

        self._wandb = wandb
        self._run = wandb.init(project=project, id=run_name(path, "wandb"), name=path.name, dir=str(path), config=settings, resume="allow")
        self._done: dict[str, int] = {}

    def begin(self, stage: str) -> None:
        """Ask which steps are there already."""
        self._run.define_metric(f"{stage}/step")
        self._run.define_metric(f"{stage}/*", step_metric=f"{stage}/step")
        self._done[stage] = int(self._run.summary.get(f"{stage}/step", -1))

    def log(self, stage: str, step: int, numbers: Mapping[str, float]) -> None:
        """Send the numbers of a step that is new."""
        if step > self._done[stage]:
            self._run.log({f"{stage}/step": step} | {f"{stage}/{name}": number for name, number in numbers.items()})

    def picture(self, stage: str, name: str, image: npt.NDArray[np.uint8]) -> None:
        """Send a picture (height, width, 3); it takes the place of an earlier one in the run's summary."""
        self._run.summary[f"{stage}/{name}"] = self._wandb.Image(image)

    def flush(self) -> None:
        """Leave it to wandb, which writes by itself."""

    def close(self) -> None:
        """Send everything."""
        self._run.finish()

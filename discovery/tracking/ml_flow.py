"""MLflow: ``tracker=mlflow``, to the server that MLFLOW_TRACKING_URI names."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from discovery.tracking.run_name import FILE, keep_run_name, run_name


class MLflow:
    """Logs to an MLflow run that a resumed run goes on with; steps that it has already are not sent again."""

    def __init__(self, path: Path, project: str, settings: dict[str, Any]) -> None:
        import mlflow

        self._client = mlflow.MlflowClient()
        self._done: dict[str, int] = {}
        if (path / FILE).exists():
            self._run = run_name(path, "mlflow")
            return
        found = self._client.get_experiment_by_name(project)
        experiment = self._client.create_experiment(project) if found is None else found.experiment_id
        self._run = keep_run_name(path, "mlflow", self._client.create_run(experiment, run_name=path.name).info.run_id)
        for key, value in settings.items():
            self._client.log_param(self._run, key, value)

    def begin(self, stage: str) -> None:
        """Ask which steps are there already."""
        history = self._client.get_metric_history(self._run, f"{stage}/step")
        self._done[stage] = max((entry.step for entry in history), default=-1)

    def log(self, stage: str, step: int, numbers: Mapping[str, float]) -> None:
        """Send the numbers of a step that is new, the step itself last: what was cut off before it is sent again."""
        if step > self._done[stage]:
            for name, number in {**numbers, "step": step}.items():
                self._client.log_metric(self._run, f"{stage}/{name}", number, step=step)

    def picture(self, stage: str, name: str, image: npt.NDArray[np.uint8]) -> None:
        """Send a picture (height, width, 3)."""
        self._client.log_image(self._run, image, f"{stage}/{name.replace(' ', '-')}.png")

    def flush(self) -> None:
        """Do nothing: every number is sent at once."""

    def close(self) -> None:
        """Say that the run has ended for now."""
        self._client.set_terminated(self._run)

"""The five metrics of Brown et al. (2018), raw as they published them or standardised."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from discovery.dataset import Dataset
from discovery.representations.interface import Fitted
from discovery.run_folder import RunFolder
from swarm_envs.metrics import hand_crafted
from swarm_envs.simulation import Trajectories

STANDARD = "standard.safetensors"
"""File of the run folder with mean and scale."""


@dataclass(frozen=True)
class HandCrafted:
    """Average speed, angular momentum, radial variance, scatter and group rotation, each less a mean and over a scale."""

    mean: npt.NDArray[np.float64]
    """(5,)"""
    scale: npt.NDArray[np.float64]
    """(5,)"""
    dimension: int = 5

    def embed(self, trajectories: Trajectories) -> npt.NDArray[np.float32]:
        """Measure each rollout: (W, 5)."""
        return np.asarray((hand_crafted(trajectories) - self.mean) / self.scale, dtype=np.float32)


def fit_hand_crafted(folder: RunFolder, dataset: Dataset) -> Fitted:
    """Return the metrics, standardised over the dataset's random controllers when the settings ask for it."""
    if not folder.settings.representation.standardise:
        return Fitted(HandCrafted(np.zeros(5), np.ones(5)), "five hand-crafted metrics, raw")
    scale = dataset.metrics.std(axis=0)
    made = HandCrafted(dataset.metrics.mean(axis=0), np.where(scale > 0.0, scale, 1.0))
    folder.write_tensors(STANDARD, {"mean": made.mean, "scale": made.scale}, {})
    return Fitted(made, "five hand-crafted metrics, standardised over the dataset", done="mean and spread of five metrics")


def load_hand_crafted(folder: RunFolder) -> HandCrafted:
    """Return the metrics as a finished run had them."""
    saved = folder.read_tensors(STANDARD)
    return HandCrafted(np.zeros(5), np.ones(5)) if saved is None else HandCrafted(saved.tensors["mean"], saved.tensors["scale"])

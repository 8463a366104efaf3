"""The five metrics of Brown et al. (2018): raw as they published them, two of them by their square roots, or standardised."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from discovery.representations.interface import Fitted
from discovery.representations.square_root_scaling import with_square_roots
from discovery.rollouts.dataset import Dataset
from discovery.runs.run_folder import RunFolder
from discovery.settings import HandCraftedSettings
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
    square_root: bool = False
    """Whether radial variance and scatter enter by their square roots."""
    dimension: int = 5

    def embed(self, trajectories: Trajectories) -> npt.NDArray[np.float32]:
        """Measure each rollout: (W, 5)."""
        metrics = hand_crafted(trajectories)
        return np.asarray(((with_square_roots(metrics) if self.square_root else metrics) - self.mean) / self.scale, dtype=np.float32)


def fit_hand_crafted(folder: RunFolder, dataset: Dataset) -> Fitted:
    """Return the metrics, standardised over the dataset's random controllers when the settings ask for it."""
    settings: HandCraftedSettings = folder.settings.representation
    what = "five hand-crafted metrics" + (", radial variance and scatter by their square roots" if settings.square_root else "")
    if not settings.standardise:
        return Fitted(_raw(settings.square_root), what if settings.square_root else f"{what}, raw")
    metrics = with_square_roots(dataset.metrics) if settings.square_root else dataset.metrics
    scale = metrics.std(axis=0)
    made = HandCrafted(metrics.mean(axis=0), np.where(scale > 0.0, scale, 1.0), settings.square_root)
    folder.write_tensors(STANDARD, {"mean": made.mean, "scale": made.scale}, {})
    return Fitted(made, f"{what}, standardised over the dataset", done="mean and spread of five metrics")


def load_hand_crafted(folder: RunFolder) -> HandCrafted:
    """Return the metrics as a finished run had them."""
    saved, square_root = folder.read_tensors(STANDARD), folder.settings.representation.square_root
    return _raw(square_root) if saved is None else HandCrafted(saved.tensors["mean"], saved.tensors["scale"], square_root)


def _raw(square_root: bool) -> HandCrafted:
    return HandCrafted(np.zeros(5), np.ones(5), square_root)

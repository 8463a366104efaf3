"""The five metrics of Brown et al. (2018): raw as they published them, two of them by their roots, or standardised."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from discovery.representations.interface import Fitted
from discovery.representations.square_root_scaling import with_roots
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
    roots: bool = False
    """Whether radial variance and scatter enter by their roots."""
    dimension: int = 5

    def embed(self, trajectories: Trajectories) -> npt.NDArray[np.float32]:
        """Measure each rollout: (W, 5)."""
        metrics = hand_crafted(trajectories)
        return np.asarray(((with_roots(metrics) if self.roots else metrics) - self.mean) / self.scale, dtype=np.float32)


def fit_hand_crafted(folder: RunFolder, dataset: Dataset) -> Fitted:
    """Return the metrics, standardised over the dataset's random controllers when the settings ask for it."""
    settings: HandCraftedSettings = folder.settings.representation
    what = "five hand-crafted metrics" + (", radial variance and scatter by their roots" if settings.roots else "")
    if not settings.standardise:
        return Fitted(_raw(settings.roots), what if settings.roots else f"{what}, raw")
    metrics = with_roots(dataset.metrics) if settings.roots else dataset.metrics
    scale = metrics.std(axis=0)
    made = HandCrafted(metrics.mean(axis=0), np.where(scale > 0.0, scale, 1.0), settings.roots)
    folder.write_tensors(STANDARD, {"mean": made.mean, "scale": made.scale}, {})
    return Fitted(made, f"{what}, standardised over the dataset", done="mean and spread of five metrics")


def load_hand_crafted(folder: RunFolder) -> HandCrafted:
    """Return the metrics as a finished run had them."""
    saved, roots = folder.read_tensors(STANDARD), folder.settings.representation.roots
    return _raw(roots) if saved is None else HandCrafted(saved.tensors["mean"], saved.tensors["scale"], roots)


def _raw(roots: bool) -> HandCrafted:
    return HandCrafted(np.zeros(5), np.ones(5), roots)

"""What chance does to an embedding: how rollouts of one controller differ that begin from different starts.

Distances in units of that are small between what chance alone can turn into one another, and large between what it cannot (within-class
covariance normalisation, Hatch and others 2006, with controllers for classes). Labels play no part.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from discovery.progress import bar
from discovery.representations.interface import Representation
from discovery.rollouts.dataset import rollouts_again
from discovery.rollouts.simulator import Simulator
from discovery.runs.run_folder import CHANCE, RunFolder

FloatArray = npt.NDArray[np.float64]

SHRINKAGE = 0.1
"""Share of the covariance that is replaced by the same in every direction: in directions where the dataset shows hardly any chance, its
few controllers say little."""


def covariance_by_chance(folder: RunFolder, simulator: Simulator, representation: Representation) -> FloatArray:
    """Return the covariance (d, d) of embeddings among rollouts of one controller, over the dataset; the folder keeps it.

    The dataset's rollouts are simulated once more, which is no new draw: ``dataset.starts`` of them are of each controller.
    """
    folder.forget_damaged(CHANCE)
    saved = folder.read_tensors(CHANCE)
    if saved is None:
        parts = []
        with bar(folder.settings.dataset.videos, "chance", "rollouts") as progress:
            for rollouts in rollouts_again(folder, simulator):
                parts.append(representation.embed(rollouts))
                progress.update(len(parts[-1]))
        embeddings = np.concatenate(parts)
        found = within_groups(embeddings.astype(np.float64), folder.settings.dataset.starts)
        folder.write_tensors(CHANCE, {"covariance": found}, {"starts": folder.settings.dataset.starts})
        return found
    return saved.tensors["covariance"]


def within_groups(rows: FloatArray, size: int) -> FloatArray:
    """Return the covariance (d, d) of rows (N, d) about the means of their groups, ``size`` neighbouring rows each, at least two."""
    groups = rows.reshape(-1, size, rows.shape[1])
    away = (groups - groups.mean(axis=1, keepdims=True)).reshape(rows.shape)
    return np.asarray(away.T @ away / (len(rows) - len(groups)))


def in_units_of(covariance: FloatArray) -> FloatArray:
    """Return what embeddings are multiplied with to have distances in units of a covariance (d, d): its root's inverse, shrunk."""
    mean = np.trace(covariance) / len(covariance)
    if mean == 0.0:
        return np.eye(len(covariance))  # chance changes nothing
    variances, axes = np.linalg.eigh((1.0 - SHRINKAGE) * covariance + SHRINKAGE * mean * np.eye(len(covariance)))
    return np.asarray((axes / np.sqrt(variances)) @ axes.T)

"""Within-class covariance of embeddings: how rollouts of one controller differ that begin from different starts.

Distances in units of it (:meth:`discovery.representations.affine.AffineTransform.within_class`) are small between what chance alone can
turn into one another, and large between what it cannot: within-class covariance normalisation (WCCN, Hatch and others 2006), with
controllers for classes. Labels play no part.
"""

from __future__ import annotations

import numpy as np

from discovery.progress import bar
from discovery.representations.affine import FloatArray
from discovery.representations.interface import Representation
from discovery.rollouts.dataset import rollouts_again
from discovery.rollouts.simulator import Simulator
from discovery.runs.run_folder import COVARIANCE, RunFolder


def within_class_covariance(folder: RunFolder, simulator: Simulator, representation: Representation) -> FloatArray:
    """Return the covariance (d, d) of embeddings among rollouts of one controller, over the dataset; the folder keeps it.

    The dataset's rollouts are simulated once more, which is no new draw: ``dataset.starts`` of them are of each controller.
    """
    folder.forget_damaged(COVARIANCE)
    saved = folder.read_tensors(COVARIANCE)
    if saved is not None:
        return saved.tensors["covariance"]
    parts = []
    with bar(folder.settings.dataset.videos, "WCCN", "rollouts") as progress:
        for rollouts in rollouts_again(folder, simulator):
            parts.append(representation.embed(rollouts))
            progress.update(len(parts[-1]))
    embeddings, starts = np.concatenate(parts).astype(np.float64), folder.settings.dataset.starts
    found = covariance_within_groups(embeddings, starts)
    folder.write_tensors(COVARIANCE, {"covariance": found}, {"starts": starts})
    return found


def covariance_within_groups(rows: FloatArray, size: int) -> FloatArray:
    """Return the covariance (d, d) of rows (N, d) about the means of their groups, ``size`` neighbouring rows each, at least two."""
    groups = rows.reshape(-1, size, rows.shape[1])
    away = (groups - groups.mean(axis=1, keepdims=True)).reshape(rows.shape)
    return np.asarray(away.T @ away / (len(rows) - len(groups)))

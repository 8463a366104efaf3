"""Representations: from rollouts to embeddings, one interface for all of them.

A new one is a config in ``configs/representation/``, a settings class in :mod:`discovery.settings`, a module here with a function that
returns a :class:`Fitted`, and a line in :data:`METHODS`.
"""

from __future__ import annotations

from collections.abc import Callable

from discovery.representations.hand_crafted import fit_hand_crafted, load_hand_crafted
from discovery.representations.interface import Fitted, Representation
from discovery.representations.simclr import fit_simclr
from discovery.representations.triplet import fit_triplet
from discovery.representations.untrained import fit_untrained
from discovery.representations.videos import load_videos
from discovery.rollouts.dataset import Dataset
from discovery.runs.run_folder import RunFolder

METHODS: dict[str, Callable[[RunFolder, Dataset], Fitted]] = {
    "hand_crafted": fit_hand_crafted,
    "simclr": fit_simclr,
    "triplet": fit_triplet,
    "untrained": fit_untrained,
}
"""How each ``representation.method`` is fitted."""


def fit(folder: RunFolder, dataset: Dataset) -> Fitted:
    """Fit the representation that a run's settings ask for, or read what the folder holds already."""
    return METHODS[folder.settings.representation.method](folder, dataset)


def load(folder: RunFolder) -> Representation:
    """Return the representation of a finished run.

    Raises:
        DiscoveryError: When the folder lacks it, or it is damaged.
    """
    if folder.settings.representation.method == "hand_crafted":
        return load_hand_crafted(folder)
    return load_videos(folder)


__all__ = ["METHODS", "Fitted", "Representation", "fit", "load"]

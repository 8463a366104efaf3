"""Runs that repeat one another with other seeds, and what they say together."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from discovery.errors import DiscoveryError
from discovery.saved_run import Run, load_run

FloatArray = npt.NDArray[np.float64]


def representation_name(run: Run) -> str:
    """Return how a run's representation is called in tables."""
    settings = run.settings.representation
    if settings.method == "hand_crafted":
        return "hand-crafted, standardised" if settings.standardise else "hand-crafted"
    if settings.method == "untrained":
        origin = run.metrics["representation"]["origin"]
        return "ImageNet ResNet18" if origin.startswith("ImageNet") else "random ResNet18"
    if settings.method == "triplet":
        return "triplet learning" if settings.judgements else "triplet learning (simulated annotator)"
    return "SimCLR"


def load_groups(folders: Sequence[Path]) -> dict[str, list[Run]]:
    """Read finished runs, grouped by representation.

    Raises:
        DiscoveryError: When a folder holds no finished run, or the runs are of different worlds.
    """
    runs = [load_run(folder) for folder in folders]
    worlds = {(run.manifest["world"], run.settings.engine, run.settings.steps) for run in runs}
    if len(worlds) != 1:
        raise DiscoveryError("the runs differ in world, engine or steps; evaluate those of one world together")
    groups: dict[str, list[Run]] = {}
    for run in runs:
        groups.setdefault(representation_name(run), []).append(run)
    return groups


def mean_and_error(values: Sequence[npt.ArrayLike]) -> tuple[FloatArray, FloatArray]:
    """Return mean and standard error over runs (first axis); the error of one run is NaN."""
    stack = np.asarray(values, dtype=float)
    error = np.full(stack.shape[1:], np.nan) if len(stack) < 2 else stack.std(axis=0, ddof=1) / np.sqrt(len(stack))
    return stack.mean(axis=0), error

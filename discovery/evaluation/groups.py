"""Runs that repeat one another with other seeds, and what they say together."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import stats

from discovery.errors import DiscoveryError
from discovery.saved_run import Run, load_run
from discovery.settings import LOCATION_KEYS, EncoderSettings, flat

FloatArray = npt.NDArray[np.float64]

PERSONAL = ("name", "seed", "threads", *LOCATION_KEYS)
"""Settings in which repetitions of one run differ."""
ASIDE = ("report.", "tracker")
"""Beginnings of settings that change nothing of the result."""


def representation_name(run: Run) -> str:
    """Return how a run's representation is called in tables."""
    settings, words = run.settings.representation, _method_name(run)
    if settings.method == "simclr" and (starts := run.settings.dataset.starts) > 1:
        words += f", pairs of {starts} starts"
    if isinstance(settings, EncoderSettings) and settings.metrics > 0.0:
        words += ", metrics beside" + (" by roots" if settings.metrics_square_root else "")
    return words


def _method_name(run: Run) -> str:
    settings = run.settings.representation
    if settings.method == "hand_crafted":
        words = ["hand-crafted", *["roots"] * settings.square_root, *["standardised"] * settings.standardise]
        return ", ".join(words)
    if settings.method == "untrained":
        origin = run.metrics["representation"]["origin"]
        return "ImageNet ResNet18" if origin.startswith("ImageNet") else "random ResNet18"
    if settings.method == "triplet":
        return "triplet learning" if settings.judgements else "triplet learning (simulated annotator)"
    return "SimCLR" if settings.method == "simclr" else str(settings.method)


def load_groups(folders: Sequence[Path]) -> dict[str, list[Run]]:
    """Read finished runs of one world, grouped by representation; see :func:`group`.

    Raises:
        DiscoveryError: When a folder holds no finished run, or the runs are of different worlds.
    """
    runs = [load_run(folder) for folder in folders]
    worlds = {(run.manifest["world"], run.settings.engine, run.settings.steps) for run in runs}
    if len(worlds) != 1:
        raise DiscoveryError("the runs differ in world, engine or steps; evaluate those of one world together")
    return group(runs, representation_name)


def group(runs: Sequence[Run], name: Callable[[Run], str]) -> dict[str, list[Run]]:
    """Group runs by name; those of one name that differ in more than the seed become groups of their own, told apart by their settings."""
    named: dict[str, list[Run]] = {}
    for run in runs:
        named.setdefault(name(run), []).append(run)
    groups: dict[str, list[Run]] = {}
    for title, members in named.items():
        settings = [flat(run.settings) for run in members]
        told = _telling(settings)
        for run, values in zip(members, settings, strict=True):
            words = ", ".join(f"{key}={values.get(key)}" for key in told)
            groups.setdefault(f"{title}; {words}" if words else title, []).append(run)
    return groups


def _telling(settings: Sequence[dict[str, Any]]) -> list[str]:
    """Return the keys whose values differ, those that repetitions differ in left out."""
    keys = sorted({key for values in settings for key in values if key not in PERSONAL and not key.startswith(ASIDE)})
    return [key for key in keys if any(values.get(key) != settings[0].get(key) for values in settings)]


def mean_and_error(values: Sequence[npt.ArrayLike]) -> tuple[FloatArray, FloatArray]:
    """Return mean and standard error over runs (first axis); the error of one run is NaN."""
    stack = np.asarray(values, dtype=float)
    error = np.full(stack.shape[1:], np.nan) if len(stack) < 2 else stack.std(axis=0, ddof=1) / np.sqrt(len(stack))
    return stack.mean(axis=0), error


def interval(shares: Sequence[float]) -> tuple[float, float, float]:
    """Return the mean of shares over runs and its 95 % interval by Student's t, within 0 to 1; NaN for what cannot be said."""
    known = [share for share in shares if np.isfinite(share)]
    if not known:
        return float("nan"), float("nan"), float("nan")
    mean, error = mean_and_error(known)
    half = stats.t.ppf(0.975, len(known) - 1) * error if len(known) > 1 else np.nan
    return float(mean), float(np.clip(mean - half, 0, 1)), float(np.clip(mean + half, 0, 1))

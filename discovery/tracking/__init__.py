"""Trackers: TensorBoard's event files by default, other services where they are installed.

A new one is a class with the methods of :class:`Tracker`, a line in :data:`TRACKERS` and in :data:`PACKAGES`, a word in
``TrackerSettings`` and a file in ``configs/tracker``.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from typing import TYPE_CHECKING

from discovery.errors import DiscoveryError
from discovery.settings import Settings, flat
from discovery.tracking.event_files import EventFiles
from discovery.tracking.forgiving import Forgiving
from discovery.tracking.interface import Silent, Tracker
from discovery.tracking.ml_flow import MLflow
from discovery.tracking.weights_and_biases import WeightsAndBiases

if TYPE_CHECKING:
    from discovery.run_folder import RunFolder

TRACKERS: dict[str, Callable[[RunFolder], Tracker]] = {
    "none": lambda folder: Silent(),
    "tensorboard": lambda folder: EventFiles(folder.path),
    "wandb": lambda folder: WeightsAndBiases(folder.path, folder.settings.tracker.project, flat(folder.settings)),
    "mlflow": lambda folder: MLflow(folder.path, folder.settings.tracker.project, flat(folder.settings)),
}
"""How each ``tracker.method`` is made."""

PACKAGES = {"tensorboard": "'swarm-envs[discovery]'", "wandb": "wandb", "mlflow": "mlflow"}
"""What to install for each."""

SERVICES = {"wandb", "mlflow"}
"""Those that log to somewhere else, and may fail there."""


def check_tracker(settings: Settings) -> None:
    """Refuse a tracker whose library is missing.

    Raises:
        DiscoveryError: When it is not installed.
    """
    name = settings.tracker.method
    if name in PACKAGES and importlib.util.find_spec(name) is None:
        raise DiscoveryError(f"tracker={name}: {name} is not installed; pip install {PACKAGES[name]}, or take tracker=none")


def make_tracker(folder: RunFolder) -> Tracker:
    """Return the tracker that a run's settings ask for."""
    name = folder.settings.tracker.method
    if name in SERVICES:
        return Forgiving(name, lambda: TRACKERS[name](folder))
    return TRACKERS[name](folder)


__all__ = ["PACKAGES", "TRACKERS", "Silent", "Tracker", "check_tracker", "make_tracker"]

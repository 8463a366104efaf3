"""Trackers: TensorBoard's event files by default, other services where they are installed.

A new one is a class with the methods of :class:`Tracker`, a line in :data:`TRACKERS` and in :data:`PACKAGES`, a word in
``TrackerSettings`` and a file in ``configs/tracker``.
"""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from pathlib import Path

from discovery.errors import DiscoveryError
from discovery.settings import Settings, flat
from discovery.tracking.best_effort import BestEffortTracker
from discovery.tracking.event_files import EventFiles
from discovery.tracking.interface import NullTracker, Tracker
from discovery.tracking.ml_flow import MLflow
from discovery.tracking.weights_and_biases import WeightsAndBiases
from swarm_envs.deprecation import forwarding

TRACKERS: dict[str, Callable[[Path, Settings], Tracker]] = {
    "none": lambda path, settings: NullTracker(),
    "tensorboard": lambda path, settings: EventFiles(path),
    "wandb": lambda path, settings: WeightsAndBiases(path, settings.tracker.project, flat(settings)),
    "mlflow": lambda path, settings: MLflow(path, settings.tracker.project, flat(settings)),
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


def make_tracker(path: Path, settings: Settings) -> Tracker:
    """Return the tracker that the settings of the run in the folder ``path`` ask for."""
    name = settings.tracker.method
    if name in SERVICES:
        return BestEffortTracker(name, lambda: TRACKERS[name](path, settings))
    return TRACKERS[name](path, settings)


__getattr__ = forwarding(__name__, {"Silent": "discovery.tracking.interface.NullTracker"})
__all__ = ["PACKAGES", "TRACKERS", "NullTracker", "Tracker", "check_tracker", "make_tracker"]

"""The settings of one tiny run, which many tests share."""

from __future__ import annotations

from hydra import compose, initialize_config_dir

from discovery.command import CONFIGS
from discovery.settings import Settings, read_settings

SIMCLR = (
    "representation.weights=random",
    "representation.epochs=2",
    "representation.batch=12",
    "representation.warmup_epochs=1",
    "representation.checkpoint_seconds=0",
)
SHORT = (
    "steps=40",
    "threads=1",
    "dataset.videos=24",
    "dataset.chunk=12",
    "search.population=8",
    "search.generations=3",
    "search.neighbours=4",
    "report.map_points=20",
    "report.map_iterations=250",
)
TINY = (*SHORT, *SIMCLR)
"""Overrides that keep every stage and take seconds."""


def tiny(*overrides: str, simclr: bool = True) -> Settings:
    with initialize_config_dir(str(CONFIGS), version_base="1.3"):
        return read_settings(compose("config", [*SHORT, *(SIMCLR if simclr else ()), *overrides]))

"""One tiny run, shared by the tests, and the command as a user calls it."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from hydra import compose, initialize_config_dir

from discovery.command import CONFIGS, Opened, run
from discovery.settings import Settings, read_settings

TINY = (
    "steps=40",
    "threads=1",
    "dataset.videos=24",
    "dataset.chunk=12",
    "representation.weights=random",
    "representation.epochs=2",
    "representation.batch=12",
    "representation.warmup_epochs=1",
    "representation.checkpoint_seconds=0",
    "search.population=8",
    "search.generations=3",
    "search.neighbours=4",
    "report.map_points=20",
    "report.map_iterations=250",
)
"""Overrides that keep every stage and take seconds."""


def tiny(*overrides: str) -> Settings:
    with initialize_config_dir(str(CONFIGS), version_base="1.3"):
        return read_settings(compose("config", [*TINY, *overrides]))


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a finished tiny run."""
    path = tmp_path_factory.mktemp("discovery") / "finished"
    run(tiny(f"folder={path}"), given=True, opened=Opened())
    return path


@pytest.fixture
def command(tmp_path: Path) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Call ``python -m discovery`` away from the repository."""
    root = str(CONFIGS.parent)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([root, os.environ.get("PYTHONPATH", "")])}

    def call(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [sys.executable, "-m", "discovery", *words],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )

    return call

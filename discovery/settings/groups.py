"""Settings of a run, one dataclass for each config group; what they mean is said in ``configs/``."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

from omegaconf import MISSING

from discovery.settings.fields import choice, number


@dataclass
class DatasetSettings:
    """Videos of random controllers."""

    videos: int = number(2)
    frames: int = number(1, 64)
    trail: bool = False
    size: int = number(8, 512)
    chunk: int = number(1)
    starts: int = number(1, 100, neutral=1)


@dataclass
class SearchSettings:
    """Which controllers are tried, and which of them have children."""

    method: str = choice("novelty", "random", "isoline")
    archive: str = choice("proximity", "cvt", neutral="proximity")
    distance: str = choice("euclidean", "cosine", neutral="euclidean")
    population: int = number(2)
    generations: int = number(1)
    neighbours: int = number(1)
    tournament: int = number(1)
    crossover: float = number(0.0, 1.0)
    mutation: float = number(0.0, 1.0)
    mutation_step: float = number(0.0, 10.0)
    warmup: int = number(0, neutral=0)
    cells: int = number(2, neutral=250)
    iso_sigma: float = number(0.0, neutral=0.01)
    line_sigma: float = number(0.0, neutral=0.2)
    minimal_criterion: float = number(0.0, 1.0, neutral=0.0)
    min_speed: float = number(0.0, neutral=0.0)
    min_turn_rate: float = number(0.0, neutral=0.0)
    include: list[Any] = dataclasses.field(default_factory=list)  # omegaconf takes no whole numbers for nested floats


@dataclass
class ClusteringSettings:
    """From the archive to a few behaviours."""

    method: str = choice("kmedoids")
    medoids: int = number(1)
    of: str = choice("everything", "archive", neutral="everything")
    standardise: bool = False
    whiten: bool = False
    wccn: bool = False
    repeatable: int = number(0, neutral=0)
    sample: int = number(10, neutral=10_000)


@dataclass
class ReportSettings:
    """The page at the end."""

    method: str = choice("html")
    map_points: int = number(1)
    map_iterations: int = number(250)
    frame_every: int = number(1)


@dataclass
class TrackerSettings:
    """Where progress can be watched."""

    method: str = choice("tensorboard", "none", "wandb", "mlflow", neutral="tensorboard")
    project: str = "swarm-envs"


@dataclass
class Settings:
    """A whole run."""

    name: str = MISSING
    world: str = MISSING
    engine: str = choice("chipmunk", "disc")
    steps: int = number(2)
    seed: int = number(0, 2**63 - 1)
    threads: int | None = number(1)
    runs: str = MISSING
    folder: str | None = MISSING
    resume: str | None = MISSING
    dataset: DatasetSettings = dataclasses.field(default_factory=DatasetSettings)
    representation: Any = MISSING
    """One of :data:`discovery.settings.representation.REPRESENTATIONS`."""
    search: SearchSettings = dataclasses.field(default_factory=SearchSettings)
    clustering: ClusteringSettings = dataclasses.field(default_factory=ClusteringSettings)
    report: ReportSettings = dataclasses.field(default_factory=ReportSettings)
    tracker: TrackerSettings = dataclasses.field(default_factory=TrackerSettings)


LOCATION_KEYS = ("runs", "folder", "resume")
"""Settings that say where, not what: they may differ when a run is resumed."""

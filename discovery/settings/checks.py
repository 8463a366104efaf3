"""Refuses settings out of bounds, and those that do not go together."""

from __future__ import annotations

import dataclasses
from typing import Any

from discovery.errors import DiscoveryError
from discovery.settings.groups import DatasetSettings, SearchSettings, Settings
from discovery.settings.representation import EncoderSettings, SimCLRSettings, TrainedSettings


def check(settings: Settings) -> None:
    """Check every setting by itself, then all together.

    Raises:
        DiscoveryError: On the first that cannot be.
    """
    _check_bounds(settings, "")
    _check_together(settings)


def _check_bounds(part: Any, prefix: str) -> None:
    for field in dataclasses.fields(part):
        key, value = prefix + field.name, getattr(part, field.name)
        if dataclasses.is_dataclass(value):
            _check_bounds(value, key + ".")
        options = field.metadata.get("options")
        if options and value not in options:
            raise DiscoveryError(f"{key}: given {value!r}, expected {' or '.join(map(str, options))}")
        if "low" in field.metadata and value is not None:
            low, high = field.metadata["low"], field.metadata["high"]
            for item in value if isinstance(value, list) else [value]:
                if not low <= item <= high:
                    bound = f"from {low:g} to {high:g}" if high < float("inf") else f"of at least {low:g}"
                    raise DiscoveryError(f"{key}: given {item!r}, expected a number {bound}")


def _check_together(settings: Settings) -> None:
    evaluations = settings.search.population * settings.search.generations
    representation = settings.representation
    if settings.clustering.medoids > evaluations:
        raise DiscoveryError(
            f"clustering.medoids: given {settings.clustering.medoids}, but the search makes only {evaluations} evaluations"
        )
    _check_dataset(settings.dataset)
    controllers = settings.dataset.videos // settings.dataset.starts
    if isinstance(representation, SimCLRSettings) and representation.batch > controllers:
        of = "dataset.videos" if settings.dataset.starts == 1 else "the controllers of the dataset, dataset.videos / dataset.starts"
        raise DiscoveryError(f"representation.batch: given {representation.batch}, expected at most {of}, {controllers}")
    if isinstance(representation, EncoderSettings) and representation.metrics_square_root and representation.metrics == 0.0:
        raise DiscoveryError("representation.metrics_square_root: given true, but representation.metrics=0 puts none beside the embedding")
    if isinstance(representation, TrainedSettings):
        crop = representation.crop_scale
        if len(crop) != 2 or crop[0] > crop[1]:
            raise DiscoveryError(f"representation.crop_scale: given {crop}, expected [smallest, largest]")
    _check_clustering(settings)
    _check_search(settings.search)
    if len(settings.search.include) > settings.search.population:
        raise DiscoveryError(f"search.include: given {len(settings.search.include)} controllers, expected at most search.population")


def _check_dataset(dataset: DatasetSettings) -> None:
    for name in ("videos", "chunk"):
        if (given := getattr(dataset, name)) % dataset.starts:
            raise DiscoveryError(f"dataset.{name}: given {given}, expected a multiple of dataset.starts, {dataset.starts}")


def _check_clustering(settings: Settings) -> None:
    clustering, starts = settings.clustering, settings.dataset.starts
    if clustering.wccn and starts < 2:
        raise DiscoveryError(f"clustering.wccn: needs dataset.starts of 2 or more, given {starts}")
    if clustering.wccn and (clustering.standardise or clustering.whiten):
        other = "standardise" if clustering.standardise else "whiten"
        raise DiscoveryError(f"clustering.wccn: given together with clustering.{other}, expected one of them")


def _check_search(search: SearchSettings) -> None:
    drawn = search.warmup * search.population
    if search.archive == "cvt" and search.method == "novelty":
        raise DiscoveryError("search.archive: given 'cvt', but search.method=novelty measures against everything; take random or isoline")
    if search.archive == "cvt" and drawn < search.cells:
        raise DiscoveryError(f"search.cells: given {search.cells}, expected at most the {drawn} evaluations of search.warmup")
    if search.archive == "cvt" and search.distance == "cosine":
        raise DiscoveryError(
            "search.distance: given 'cosine', but search.archive=cvt has Euclidean cells; take representation.normalise=true"
        )
    if search.method == "isoline" and search.warmup < 1:
        raise DiscoveryError("search.warmup: given 0, expected 1 or more: isoline variation needs parents")
    if search.warmup >= search.generations:
        raise DiscoveryError(f"search.warmup: given {search.warmup}, expected fewer than search.generations, {search.generations}")
    if search.minimal_criterion > 0 and search.method != "novelty":
        raise DiscoveryError(f"search.minimal_criterion: works with search.method=novelty only, given {search.method}")

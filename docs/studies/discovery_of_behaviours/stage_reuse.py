"""Stages that one run has made and another would make again, bit for bit: reused instead."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from discovery.files.tensor_file import DamagedFileError
from discovery.representations.triplet import JUDGEMENTS
from discovery.runs.manifest import world_digest
from discovery.runs.run_folder import ENCODER, RunFolder, notice, open_folder, read_manifest
from discovery.settings import Settings
from docs.studies.discovery_of_behaviours.plan import Planned
from swarm_envs.worlds import load_world

AFTER_TRAINING = {
    "simclr": {"symmetries", "whiten", "whiten_variance", "normalise", "metrics", "metrics_square_root"},
    "triplet": {"symmetries", "whiten", "whiten_variance", "metrics", "metrics_square_root"},  # its loss is on normalised embeddings
    "untrained": {"symmetries", "whiten", "whiten_variance", "normalise", "metrics", "metrics_square_root"},
}
"""Settings of a representation that change what is made of the encoder's numbers, not the encoder."""
NOTE = "handed_over.json"
"""File of the run folder that says which stages come from which other run; folders keep the name that it began with."""


def reuse_stages(folder: RunFolder, others: Sequence[Planned]) -> dict[str, str]:
    """Copy stages from finished runs whose settings, as far as the stage depends on them, are the same.

    Files are read and written through the folders' own checks, so that the run goes on from them as from its own. A dataset depends on
    world, engine, steps, seed and the dataset's settings; an encoder also on the representation's and on the number of threads, a search
    on the search's too.

    Args:
        folder: Of a run that is not finished, locked.
        others: Runs of the study.

    Returns:
        The run that each stage was copied from; also in :data:`NOTE`.
    """
    wanted, given = _stages(folder.settings), _note(folder)
    for stage, needs in wanted.items():
        if stage in given:
            continue
        for other in others:
            if other.path != folder.path and _stages(other.settings).get(stage) == needs and _usable(other):
                try:
                    copied = _copy(stage, open_folder(other.path), folder)
                except DamagedFileError as error:
                    notice(f"refused {error}; making it again")
                    continue
                if copied:
                    given[stage] = f"{other.entry.kind}/{other.entry.name}/{other.path.name}"
                    folder.write_json(NOTE, given)
                break
    return given


def _stages(settings: Settings) -> dict[str, Any]:
    """Return what each stage depends on."""
    dataset = {
        "world": settings.world, "engine": settings.engine, "steps": settings.steps, "seed": settings.seed,
        "dataset": dataclasses.asdict(settings.dataset),
    }  # fmt: skip
    representation = dataclasses.asdict(settings.representation)
    method = representation["method"]
    trained = {key: value for key, value in representation.items() if key not in AFTER_TRAINING.get(method, set())}
    stages: dict[str, Any] = {"dataset": dataset}
    if method in AFTER_TRAINING:
        stages["encoder"] = {**dataset, "threads": settings.threads, "representation": trained}
    search = dataclasses.asdict(settings.search)
    stages["search"] = {**dataset, "threads": settings.threads, "representation": representation, "search": search}
    return stages


def _usable(other: Planned) -> bool:
    """Say whether a run is finished, in the world as it is today."""
    manifest = read_manifest(other.path) if other.path.is_dir() else None
    return manifest is not None and manifest["status"] == "finished" and manifest["world"] == world_digest(load_world(other.settings.world))


def _copy(stage: str, donor: RunFolder, folder: RunFolder) -> bool:
    """Copy the files of a stage, unless the folder has begun it by itself."""
    begun = [ENCODER, "training/step-*.safetensors"] if stage == "encoder" else [f"{stage}/*.safetensors"]
    if any(any(folder.path.glob(pattern)) for pattern in begun):
        return False
    names = [ENCODER] if stage == "encoder" else sorted(f"{stage}/{path.name}" for path in (donor.path / stage).glob("*.safetensors"))
    found = [(name, donor.read_tensors(name)) for name in names]
    for name, part in found:
        if part is not None:
            folder.write_tensors(name, part.tensors, part.metadata)
    if stage == "encoder" and (donor.path / JUDGEMENTS).exists():
        folder.write(JUDGEMENTS, (donor.path / JUDGEMENTS).read_bytes())
    return any(part is not None for _, part in found)


def _note(folder: RunFolder) -> dict[str, str]:
    path: Path = folder.path / NOTE
    found: dict[str, str] = json.loads(path.read_text(encoding="utf-8")) if path.exists() else {}
    return found

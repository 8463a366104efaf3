"""Run folders of earlier versions are read, resumed and evaluated."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from discovery import load_run
from discovery.command import RunContext, run
from discovery.evaluation.groups import representation_name
from discovery.runs.archive import read_parquet
from discovery.runs.run_folder import ARCHIVE, read_manifest
from tests.discovery.tiny_run import tiny

EARLIER = Path(__file__).parent / "earlier_runs"
"""Two runs of one config: one finished (without its dataset and its pictures), one stopped after two of three generations."""


def test_a_finished_run_of_an_earlier_version_is_read() -> None:
    found = load_run(EARLIER / "finished")
    assert [medoid.label for medoid in found.medoids] == ["random"] * 4
    assert found.embeddings.shape == (24, 5)
    assert found.representation.dimension == 5
    assert representation_name(found) == "hand-crafted, roots"


def test_a_run_stopped_in_an_earlier_version_goes_on_from_what_it_holds_and_ends_as_it_would_have(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "stopped"
    shutil.copytree(EARLIER / "stopped", path)
    before = {part: part.read_bytes() for part in path.glob("*/*.safetensors")}
    run(tiny(f"resume={path}"), given=False, context=RunContext())
    assert "refused" not in capsys.readouterr().err
    assert len(before) == 4
    assert all(part.read_bytes() == content for part, content in before.items()), "what was there is kept"
    manifest = read_manifest(path)
    assert manifest is not None
    assert manifest["status"] == "finished"
    (ours, our_clusters), (theirs, their_clusters) = read_parquet(path / ARCHIVE), read_parquet(EARLIER / "finished" / ARCHIVE)
    assert np.array_equal(ours.controllers, theirs.controllers)
    assert np.allclose(ours.embeddings, theirs.embeddings, rtol=1e-4, atol=1e-6)
    assert np.array_equal(our_clusters.medoids, their_clusters.medoids)

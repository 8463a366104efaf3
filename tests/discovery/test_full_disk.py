"""A disk that fills up at any moment stops a run with one line; nothing earlier is lost, and with space again it goes on."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import pytest

from discovery import command
from discovery.runs.run_folder import ARCHIVE, CONFIG, ENCODER, LOCK, MANIFEST, METRICS, REPORT
from discovery.tracking.event_files import FOLDER
from tests.discovery.tiny_run import TINY

BEFORE = (
    *TINY, "dataset.videos=4", "dataset.chunk=4", "representation.epochs=1", "representation.batch=4", "search.population=6",
    "clustering.medoids=2",
)  # fmt: skip


def bytes_of(path: Path) -> dict[str, bytes]:
    """Every file but those that tell of the sessions."""
    files = [item for item in path.rglob("*") if item.is_file() and item.name not in (MANIFEST, LOCK, REPORT) and FOLDER not in item.parts]
    return {str(item): item.read_bytes() for item in files}


class Disk:
    """Has room for so many files that are not there yet; the next finds no place, its content is lost."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.room = 0
        self._replace = os.replace
        monkeypatch.setattr(os, "replace", self.replace)

    def replace(self, source: Path, target: Path) -> None:
        if not target.exists():
            if self.room <= 0:
                raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
            self.room -= 1
        self._replace(source, target)


def call(monkeypatch: pytest.MonkeyPatch, *words: str) -> int:
    monkeypatch.setattr("sys.argv", ["discovery", *words])
    return command.main()


@pytest.mark.slow
def test_a_disk_that_is_full_at_every_file_in_turn_loses_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Each session has room for one file that is new, so that every file in turn is the one too many."""
    path, disk = tmp_path / "run", Disk(monkeypatch)
    disk.room = 100
    assert call(monkeypatch, *BEFORE, f"folder={tmp_path / 'whole'}") == 0
    disk.room, sessions, before = 0, 0, dict[str, bytes]()
    words: tuple[str, ...] = (*BEFORE, f"folder={path}")
    capsys.readouterr()
    while (status := call(monkeypatch, *words)) != 0:
        said = capsys.readouterr().err.strip().splitlines()
        assert status == 1
        assert len(said) == 1, said
        assert "the disk is full" in said[0]
        assert not list(path.rglob("*.partial")), "half a file was left behind"
        now = bytes_of(path)
        kept = {name: content for name, content in before.items() if "/training/" not in name}  # checkpoints make room for newer ones
        assert kept.items() <= now.items(), "something earlier was lost"
        before, sessions, disk.room = now, sessions + 1, 1
        assert sessions < 40
        if (path / CONFIG).exists():
            words = (f"resume={path}",)
            if (path / MANIFEST).exists():
                assert f"finish this run with: python -m discovery resume={path}" in said[0]
    assert sessions > 10
    for name in (ARCHIVE, ENCODER, METRICS):
        assert (path / name).read_bytes() == (tmp_path / "whole" / name).read_bytes()


def test_a_full_disk_is_told_from_a_place_that_may_not_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(*_: Any, **__: Any) -> None:
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    monkeypatch.setattr(os, "replace", refuse)
    assert call(monkeypatch, *BEFORE, f"folder={tmp_path / 'run'}") == 1
    assert "cannot be written (Permission denied)" in capsys.readouterr().err


def test_a_disk_that_is_full_for_a_tracker_stops_the_run_with_one_line_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def full(*_: Any) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with monkeypatch.context() as patch:
        patch.setattr("tensorboard.summary.writer.record_writer.RecordWriter.write", full)
        assert call(patch, *BEFORE, f"folder={tmp_path / 'run'}") == 1
    said = capfd.readouterr().err.strip().splitlines()
    assert len(said) == 1, said
    assert "the disk is full" in said[0]
    assert call(monkeypatch, f"resume={tmp_path / 'run'}") == 0

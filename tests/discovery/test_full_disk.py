"""A disk that fills up at any moment stops a run with one line; nothing earlier is lost, and with space again it goes on."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import pytest

from discovery import command
from discovery.run_folder import ARCHIVE, CONFIG, ENCODER, LOCK, MANIFEST, METRICS
from discovery.tracking.event_files import FOLDER
from tests.discovery.tiny_run import TINY

BEFORE = (*TINY, "representation.epochs=1", "dataset.chunk=24", "representation.batch=24")


def bytes_of(path: Path) -> dict[str, bytes]:
    """Every file but those that each session writes anew."""
    files = [item for item in path.rglob("*") if item.is_file() and item.name not in (MANIFEST, LOCK) and FOLDER not in item.parts]
    return {str(item): item.read_bytes() for item in files}


class Disk:
    """Has room for so many more files; the next is cut short."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.room = 0
        self._sync = os.fsync
        monkeypatch.setattr(os, "fsync", self.sync)

    def sync(self, descriptor: int) -> None:
        if self.room <= 0:
            os.ftruncate(descriptor, os.fstat(descriptor).st_size // 2)
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        self.room -= 1
        self._sync(descriptor)


def call(monkeypatch: pytest.MonkeyPatch, *words: str) -> int:
    monkeypatch.setattr("sys.argv", ["discovery", *words])
    return command.main()


def test_a_disk_that_is_full_at_every_file_in_turn_loses_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Sessions have room for a file, then for one more until something new is written: every file in turn is the one too many."""
    path, disk = tmp_path / "run", Disk(monkeypatch)
    disk.room = 100
    assert call(monkeypatch, *BEFORE, f"folder={tmp_path / 'whole'}") == 0
    disk.room, patience, sessions, before = 0, 0, 0, dict[str, bytes]()
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
        # what a session writes again before it comes to something new takes room, too
        patience = 1 if now.keys() != before.keys() else patience + 1
        before, sessions, disk.room = now, sessions + 1, patience
        assert sessions < 40
        if (path / CONFIG).exists():
            words = (f"resume={path}",)
            if (path / MANIFEST).exists():
                assert f"finish this run with: python -m discovery resume={path}" in said[0]
    assert sessions > 8
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

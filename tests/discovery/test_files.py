"""What is written is whole, and what is read back is what was written."""

import errno
import os
from pathlib import Path

import numpy as np
import pytest

from discovery.errors import DiscoveryError
from discovery.files.atomic import write_atomically
from discovery.files.tensor_file import DamagedFileError, read_tensor_file, write_tensor_file
from discovery.runs.archive import read_parquet, to_parquet
from discovery.runs.run_folder import ARCHIVE, CONFIG, RunFolder, make_folder, open_folder
from tests.discovery.tiny_run import tiny


@pytest.fixture
def tensor_file(tmp_path: Path) -> Path:
    path = tmp_path / "part.safetensors"
    write_tensor_file(path, {"a": np.arange(1000.0), "b": np.zeros((0, 3), np.uint8)}, {"losses": [0.1, 1 / 3]}, "run")
    return path


def test_arrays_and_facts_come_back_to_the_last_bit(tensor_file: Path) -> None:
    read = read_tensor_file(tensor_file, "run")
    assert np.array_equal(read.tensors["a"], np.arange(1000.0))
    assert read.tensors["b"].shape == (0, 3)
    assert read.metadata == {"losses": [0.1, 1 / 3]}


def test_a_truncated_file_is_refused(tensor_file: Path) -> None:
    tensor_file.write_bytes(tensor_file.read_bytes()[:-100])
    with pytest.raises(DamagedFileError, match="not readable"):
        read_tensor_file(tensor_file, "run")


@pytest.mark.parametrize("place", [-4000, -1])
def test_a_file_with_one_changed_byte_is_refused(tensor_file: Path, place: int) -> None:
    content = bytearray(tensor_file.read_bytes())
    content[place] ^= 1
    tensor_file.write_bytes(content)
    with pytest.raises(DamagedFileError, match="checksum"):
        read_tensor_file(tensor_file, "run")


def test_a_file_with_changed_facts_is_refused(tensor_file: Path) -> None:
    content = tensor_file.read_bytes()
    assert b"0.1, 0.3" in content
    tensor_file.write_bytes(content.replace(b"0.1, 0.3", b"0.2, 0.3"))
    with pytest.raises(DamagedFileError, match="checksum"):
        read_tensor_file(tensor_file, "run")


def test_a_file_of_another_run_is_refused(tensor_file: Path) -> None:
    with pytest.raises(DamagedFileError, match="another run"):
        read_tensor_file(tensor_file, "other")


def test_a_full_disk_loses_nothing_earlier_and_says_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "file"
    write_atomically(path, "before")

    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(DiscoveryError, match="the disk is full"):
        write_atomically(path, "after")
    assert path.read_text() == "before"
    assert [item.name for item in tmp_path.iterdir()] == ["file"], "half a file was left behind"


def test_two_processes_never_write_one_folder(tmp_path: Path) -> None:
    folder = make_folder(tiny(f"folder={tmp_path / 'run'}"))
    with folder, pytest.raises(DiscoveryError, match=f"process {os.getpid()} is writing"), open_folder(folder.path):
        pass
    with open_folder(folder.path):
        pass  # released


def test_of_two_processes_that_make_one_folder_the_second_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run"
    path.mkdir()
    other = RunFolder(path, tiny())
    with other, pytest.raises(DiscoveryError, match="is writing this run folder"):  # it has made the folder, and writes its config next
        make_folder(tiny(f"folder={path}", "seed=7"))
    assert not (path / CONFIG).exists()
    make_folder(tiny(f"folder={path}", "seed=7"))
    with pytest.raises(DiscoveryError, match="holds an unfinished run"):
        make_folder(tiny(f"folder={path}"))


def test_a_folder_that_was_killed_before_its_config_is_taken(tmp_path: Path) -> None:
    (tmp_path / ".lock").touch()
    (tmp_path / f".{CONFIG}.partial").write_text("na")
    assert make_folder(tiny(f"folder={tmp_path}")).path == tmp_path


def test_a_folder_that_holds_something_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "thesis.tex").write_text("all of it")
    with pytest.raises(DiscoveryError, match="not a run folder"):
        make_folder(tiny(f"folder={tmp_path}"))
    assert [item.name for item in tmp_path.iterdir()] == ["thesis.tex"]


def test_new_folders_of_the_same_second_get_different_names(tmp_path: Path) -> None:
    names = {make_folder(tiny(f"runs={tmp_path}")).path for _ in range(3)}
    assert len(names) == 3


def test_the_archive_comes_back_from_parquet_to_the_last_bit(finished: Path) -> None:
    archive, clusters = read_parquet(finished / ARCHIVE)
    assert to_parquet(archive, clusters) == (finished / ARCHIVE).read_bytes()
    assert archive.embeddings.dtype == np.float32
    assert archive.embeddings.shape == (24, 512)

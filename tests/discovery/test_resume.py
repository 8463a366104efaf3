"""Stopped anywhere, a run resumes and ends as if it had not been stopped."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from discovery.command import RunContext, run
from discovery.errors import DiscoveryError
from discovery.runs.run_folder import ARCHIVE, ENCODER, METRICS, open_folder
from tests.discovery.stopping import run_until
from tests.discovery.tiny_run import TINY, tiny

pytestmark = pytest.mark.slow

RESULTS = (ARCHIVE, ENCODER, METRICS)


def resume(path: Path) -> None:
    run(tiny(f"resume={path}"), given=False, context=RunContext())


def assert_same_results(path: Path, expected: Path) -> None:
    for name in RESULTS:
        assert (path / name).read_bytes() == (expected / name).read_bytes(), f"{name} differs"


def stop_before(names: str, path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Start the tiny run, or resume it, and interrupt it there."""
    run_until(names, tiny(f"resume={path}" if path.exists() else f"folder={path}"), monkeypatch)


def test_the_same_seed_gives_the_same_archive_to_the_last_bit(finished: Path, tmp_path: Path) -> None:
    run(tiny(f"folder={tmp_path / 'again'}"), given=True, context=RunContext())
    assert_same_results(tmp_path / "again", finished)


def test_a_run_stopped_again_and_again_at_every_stage_ends_with_the_same_bits(
    finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "stopped"
    places = ("manifest.json", "dataset/00001", "training/start", "training/step-0000002", ENCODER, "search/00000", "search/00002", ARCHIVE)
    for place in (*places, "report.html"):
        stop_before(place, path, monkeypatch)
        assert not any((path / place).parent.glob(f"{Path(place).name}*")), f"{place} was written although the run was stopped before"
    resume(path)
    assert_same_results(path, finished)


def stopped_after_training_began(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    path = tmp_path / "stopped"
    stop_before("training/step-0000003", path, monkeypatch)
    return path


def test_a_tampered_checkpoint_is_refused_with_a_reason_and_the_one_before_is_used(
    finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = stopped_after_training_began(tmp_path, monkeypatch)
    newest = max((path / "training").glob("step-*"))
    content = bytearray(newest.read_bytes())
    content[-1000] ^= 1
    newest.write_bytes(content)
    resume(path)
    said = capsys.readouterr().err
    assert f"refused {newest}: its checksum does not match" in said
    assert said.count("discovery: refused") == 1
    assert_same_results(path, finished)


def test_damaged_parts_are_refused_and_made_again(
    finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "stopped"
    stop_before(ARCHIVE, path, monkeypatch)
    for part in ("dataset/00001.safetensors", "search/00001.safetensors"):
        (path / part).write_bytes((path / part).read_bytes()[:-50])
    resume(path)
    assert capsys.readouterr().err.count("discovery: refused") == 2
    assert_same_results(path, finished)


def test_a_tampered_encoder_is_refused(finished: Path, tmp_path: Path) -> None:
    path = tmp_path / "copy"
    shutil.copytree(finished, path)
    content = bytearray((path / ENCODER).read_bytes())
    content[-1] ^= 1
    (path / ENCODER).write_bytes(content)
    with pytest.raises(DiscoveryError, match=r"encoder\.safetensors: its checksum does not match"):
        open_folder(path).read_tensors(ENCODER)


def test_a_tampered_encoder_of_an_unfinished_run_is_refused_and_made_again_from_the_last_checkpoint(
    finished: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "stopped"
    stop_before("search/00001", path, monkeypatch)
    (path / ENCODER).write_bytes((path / ENCODER).read_bytes()[:-1])
    with monkeypatch.context() as patch:
        patch.delattr("discovery.representations.simclr.step")  # no step is needed
        resume(path)
    assert f"refused {path / ENCODER}: not readable" in capsys.readouterr().err
    assert_same_results(path, finished)
    assert not list(path.glob("training/*")), "a finished run needs no checkpoints"


@pytest.mark.parametrize("kind", ["novelty", "random", "cvt_random", "isoline"])
def test_every_kind_of_search_resumes_to_the_same_bits(kind: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    options = (
        "search.min_speed=0.02",
        "clustering.standardise=true",
        "clustering.repeatable=2",
        "search.generations=5",
        "clustering.medoids=4",
    )
    cells = (
        ("search.warmup=2", "search.cells=12", "clustering.of=archive")
        if kind in ("cvt_random", "isoline")
        else ("search.distance=cosine",)
    )
    words = ("representation=hand_crafted", "tracker=none", f"search={kind}", *options, *cells)
    whole, path = tmp_path / "whole", tmp_path / "stopped"
    run(tiny(*words, f"folder={whole}", simclr=False), given=True, context=RunContext())
    run_until("search/00003", tiny(*words, f"folder={path}", simclr=False), monkeypatch)
    assert (path / "search" / "00002.safetensors").exists()
    run(tiny(f"resume={path}"), given=False, context=RunContext())
    for name in (ARCHIVE, METRICS):
        assert (path / name).read_bytes() == (whole / name).read_bytes()


def test_ctrl_c_ends_the_command_calmly_and_the_run_resumes(finished: Path, tmp_path: Path) -> None:
    path = tmp_path / "stopped"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(Path(__file__).parents[2]), os.environ.get("PYTHONPATH", "")])}
    process = subprocess.Popen(
        [sys.executable, "-m", "discovery", *TINY, f"folder={path}"],
        env=environment,
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
    )
    deadline = time.monotonic() + 90
    while not list(path.glob("training/step-*")) and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=600)
    assert process.returncode == 130, said
    assert said.strip().splitlines()[-1].endswith(f"stopped; finish this run with: python -m discovery resume={path}")
    assert "Traceback" not in said
    resume(path)
    assert_same_results(path, finished)

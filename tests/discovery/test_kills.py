"""Killed by SIGKILL at any moment, a run resumes and ends with the bits of one that was left alone."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from discovery.runs.run_folder import ARCHIVE, CONFIG, ENCODER, MANIFEST, METRICS, part_name, read_manifest

RUNS = 10
"""Each is killed twice: while it learns, and after it was resumed, while it searches or reports."""
TINIER = (
    "dataset.videos=12", "dataset.chunk=3", "representation.batch=6", "representation.epochs=1", "search.population=6",
    "search.generations=4", "clustering.medoids=3",
)  # fmt: skip
BEGINNINGS = {"dataset": MANIFEST, "training": part_name("dataset", 3), "search": ENCODER, "report": part_name("search", 3)}
"""The file with which each stage begins."""
SECONDS = 600.0
"""Longest time that a run may take before it counts as stuck."""


class Prepared:
    """Runs that begin at once: forks of a process that has imported everything."""

    def __init__(self, log: Path) -> None:
        self._log = log.open("w")
        environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[2]), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.discovery.prepared"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._log, text=True, env=environment,
        )  # fmt: skip

    def close(self) -> None:
        assert self._process.stdin
        with self._log, self._process:
            self._process.stdin.close()
            self._process.wait(timeout=SECONDS)

    def run(self, path: Path, kill_in: str = "", after: float = 0.0) -> tuple[int, dict[str, float]]:
        """Begin or resume a run, and kill it when it has computed for ``after`` s in stage ``kill_in``.

        Returns:
            Its wait status, and how many s it had computed when each stage began and at the end.
        """
        words = [f"resume={path}"] if (path / CONFIG).exists() else [f"folder={path}", *TINIER]
        assert self._process.stdin
        assert self._process.stdout
        self._process.stdin.write(json.dumps(words) + "\n")
        self._process.stdin.flush()
        child = int(self._process.stdout.readline())
        clock, end = (~child << 3) | 2, time.monotonic() + SECONDS  # Linux's CPU clock of a process
        waiting, began, used = list(BEGINNINGS), dict[str, float](), 0.0
        while True:
            try:
                used = time.clock_gettime(clock)
            except OSError:  # it has ended
                break
            while waiting and (path / BEGINNINGS[waiting[0]]).exists():
                began[waiting.pop(0)] = used
            if time.monotonic() > end or (kill_in in began and used >= began[kill_in] + after):
                os.kill(child, signal.SIGKILL)
                break
            time.sleep(0.0005)
        return int(self._process.stdout.readline()), began | {"end": used}


@pytest.fixture
def prepared(tmp_path: Path) -> Iterator[Prepared]:
    started = Prepared(tmp_path / "log.txt")
    yield started
    started.close()


def moments(began: dict[str, float], stages: tuple[str, str]) -> list[tuple[str, float]]:
    """Stage and seconds into it at which to kill: half of :data:`RUNS` in each of two stages, evenly spread but for chance."""
    rng, names, count = np.random.default_rng(0), [*BEGINNINGS, "end"], RUNS // 2
    found = []
    for stage in stages:
        length = began[names[names.index(stage) + 1]] - began[stage]
        found += [(stage, float(0.95 * length * share)) for share in (np.arange(count) + rng.random(count)) / count]
    return found


@pytest.mark.slow
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="reads the CPU clock of another process")
def test_a_run_killed_at_any_of_twenty_moments_ends_with_the_same_bits(prepared: Prepared, tmp_path: Path) -> None:
    whole = tmp_path / "whole"
    status, began = prepared.run(whole)
    assert status == 0, (tmp_path / "log.txt").read_text()[-2000:]
    killed = []
    for number, pair in enumerate(zip(moments(began, ("dataset", "training")), moments(began, ("search", "report")), strict=True)):
        path = tmp_path / f"killed_{number}"
        for moment in pair:
            status, _ = prepared.run(path, *moment)
            if os.waitstatus_to_exitcode(status) == -signal.SIGKILL:
                killed.append(moment)
        if (manifest := read_manifest(path)) is None or manifest["status"] == "running":
            status, _ = prepared.run(path)
            assert status == 0, (tmp_path / "log.txt").read_text()[-2000:]
        for name in (ARCHIVE, ENCODER, METRICS):
            assert (path / name).read_bytes() == (whole / name).read_bytes(), f"{name} differs after kills at {pair}"
        assert not list(path.rglob("*.partial")), "half a file was left behind"
        shutil.rmtree(path)
    assert len(killed) >= 1.6 * RUNS, f"only {killed} came before the end"

"""Every study has a folder and one way to start; the commands of earlier versions forward."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
STUDIES = sorted(path.parent.name for path in (ROOT / "docs" / "studies").glob("*/__main__.py"))


def make(*words: str) -> str:
    if shutil.which("make") is None:
        pytest.skip("make is absent")
    return subprocess.run(["make", *words], cwd=ROOT, capture_output=True, text=True, check=True).stdout


def test_make_help_names_every_study_and_make_starts_it() -> None:
    named = re.findall(r"^make study-(\w+) ", make("help"), flags=re.MULTILINE)
    assert sorted(named) == STUDIES
    for name in STUDIES:
        assert f"-m docs.studies.{name} --list" in make("--dry-run", f"study-{name}", "ARGS=--list")


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("paper-study", "discovery_of_behaviours"),
        ("calibration-study", "calibration"),
        ("study-walls", "wall_following_and_milling"),
    ],
)
def test_targets_of_earlier_versions_start_the_same_and_say_the_new_name(old: str, new: str) -> None:
    printed = make("--dry-run", old)
    assert f"-m docs.studies.{new}" in printed
    assert f"is now make study-{new}" in printed


@pytest.mark.parametrize("name", STUDIES)
def test_each_study_says_what_it_takes(name: str) -> None:
    ended = subprocess.run([sys.executable, "-m", f"docs.studies.{name}", "--help"], cwd=ROOT, capture_output=True, text=True, check=True)
    assert ended.stdout.startswith(f"usage: python -m docs.studies.{name}")


def test_the_command_of_earlier_versions_forwards_to_the_study(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "discovery.evaluation", "study", "--only", "simclr", "--seeds", "1", "--out", str(tmp_path), "--list"]
    ended = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    assert re.search(r"^missing +representations +simclr +seed 0$", ended.stdout, flags=re.MULTILINE)
    (line,) = ended.stderr.splitlines()
    assert "make study-discovery_of_behaviours" in line

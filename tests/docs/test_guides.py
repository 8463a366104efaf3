"""Every snippet of the site runs as shown: page by page, in the order of the page, each page in a folder of its own."""

from __future__ import annotations

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import warnings
from dataclasses import dataclass
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
FENCE = re.compile(r"^```(?:\{code-block\} )?(\w+)\n(.*?)^```$", flags=re.DOTALL | re.MULTILINE)
CAPTION = re.compile(r":caption: (\S+)\n\n")
NEEDS = {
    "guides/discover": ("lightly", "ribs"),
    "guides/add_representation": ("lightly", "ribs"),
    "guides/deploy": ("aiohttp", "cffi"),
    "guides/firmware": ("cffi",),
}
"""Packages that a page's snippets need beside those of the tests."""
ELSEWHERE = {
    "install": "tests/packaging/test_wheel.py builds and installs as the page says",
    "guides/calibration": "tests/calibration/test_guide.py runs them",
    "guides/marl": "tests/docs/test_guide_to_marl.py runs them, each with packages of its own",
    "guides/training": "tests/envs/test_training.py runs them",
    "studies/calibration/index": "takes hours; tests/studies/test_calibration.py runs a small one",
    "studies/calibration_of_real_robots/index": "needs logs from elsewhere; tests/calibration/test_measured.py runs it where they are",
    "studies/discovery_of_behaviours/index": "takes hours; tests/studies/test_discovery_of_behaviours.py runs a small one",
    "studies/task_rewards/index": "takes a minute; tests/studies/test_task_rewards.py runs a small one",
    "studies/wall_following_and_milling/index": "takes minutes; tests/studies/test_wall_following_and_milling.py runs a small one",
}
OPEN = {"text", "yaml"}
"""Languages that nothing runs: what a program prints, and files that later snippets use."""


@dataclass(frozen=True)
class Snippet:
    """One block of code."""

    language: str
    text: str
    file: str | None
    """Path of the file that it is, where it has one."""


def snippets(page: Path) -> list[Snippet]:
    found = []
    for language, text in FENCE.findall(page.read_text(encoding="utf-8")):
        caption = CAPTION.match(text)
        found.append(Snippet(language, text[caption.end() :] if caption else text, caption[1] if caption else None))
    return found


FOLDERS = ("environments", "guides", "studies", "worlds")
WRITTEN = sorted([*DOCS.glob("*.md"), *(page for folder in FOLDERS for page in (DOCS / folder).rglob("*.md"))])
PAGES = {
    page.relative_to(DOCS).with_suffix("").as_posix(): page for page in WRITTEN if any(each.language not in OPEN for each in snippets(page))
}


def environment(root: Path) -> dict[str, str]:
    """The shell's: this Python first, the tree under test importable."""
    return {**os.environ, "PYTHONPATH": f"{root}:{ROOT}", "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}


def run(command: list[str], folder: Path, root: Path, **more: str) -> str:
    ended = subprocess.run(command, cwd=folder, env=environment(root) | more, capture_output=True, text=True, timeout=1200, check=False)
    assert ended.returncode == 0, ended.stdout[-2000:] + ended.stderr[-2000:]
    return ended.stdout


def tree_with_changes(parts: list[Snippet], folder: Path) -> Path:
    """A copy of the packages that a guide changes, changed; compiled code of the others stays valid."""
    tree = folder / "tree"
    changed = {name for part in parts for name in re.findall(r"^--- a/(\w+)/", part.text, flags=re.MULTILINE)}
    for name in changed | {part.file.split("/")[0] for part in parts if part.file}:
        shutil.copytree(ROOT / name, tree / name, symlinks=True, ignore=shutil.ignore_patterns("__pycache__"))
    for part in parts:
        if part.file:
            (tree / part.file).write_text(part.text)
        if part.language == "diff":
            ended = subprocess.run(
                ["git", "apply", "--recount", "-"], cwd=tree, input=part.text, capture_output=True, text=True, check=False
            )
            assert ended.returncode == 0, ended.stderr
    return tree


@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.real_time) if name == "guides/deploy" else name for name in PAGES])
def test_every_snippet_of_the_page_runs(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    if name in ELSEWHERE:
        return
    for package in NEEDS.get(name, ()):
        if importlib.util.find_spec(package) is None:
            pytest.skip(f"{package} is absent: the snippets of {name}.md need it")
    parts = snippets(PAGES[name])
    if any(part.language == "diff" for part in parts):
        tree = tree_with_changes(parts, tmp_path)
        for part in parts:
            if part.language == "python" and not part.file:
                # the changed simulation would take a minute to compile; a calibration takes longer than its few functions do
                interpreted = {} if "calibrate(" in part.text else {"NUMBA_DISABLE_JIT": "1"}
                run([sys.executable, "-W", "ignore", "-c", part.text], tmp_path, tree, **interpreted)
            if part.language in ("sh", "bash"):
                run(["bash", "-euo", "pipefail", "-c", part.text], tmp_path, tree)
        return
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {"__name__": Path(name).stem}
    for part in parts:
        if part.language == "python":
            with warnings.catch_warnings():
                warnings.filterwarnings("ignore", category=DeprecationWarning)  # other libraries' own
                exec(compile(part.text, f"{name}.md", "exec"), names)
        if part.language in ("sh", "bash"):
            run(["bash", "-euo", "pipefail", "-c", part.text], tmp_path, ROOT)


def test_no_snippet_is_of_a_kind_that_nothing_runs() -> None:
    assert len(PAGES) >= 18
    kinds = {part.language for page in PAGES.values() for part in snippets(page)}
    assert kinds <= {"python", "sh", "bash", "diff"} | OPEN

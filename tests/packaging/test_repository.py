"""A run names the commit of the code that made it, not of the repository in whose folder that happens to be installed."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import pytest

pytest.importorskip("torch")
from discovery.runs import manifest


@pytest.mark.skipif(shutil.which("git") is None, reason="git is absent")
def test_the_commit_is_that_of_a_repository_that_tracks_the_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def git(*words: str) -> None:
        who = ("-c", "user.name=somebody", "-c", "user.email=somebody@example.org")
        subprocess.run(["git", *who, *words], cwd=tmp_path, check=True, capture_output=True)

    code = tmp_path / "manifest.py"
    code.touch()
    monkeypatch.setattr(manifest, "__file__", str(code))
    assert manifest._git() is None, "no repository"
    git("init")
    git("commit", "--allow-empty", "--message", "theirs")
    assert manifest._git() is None, "a repository that knows nothing of this file"
    git("add", "manifest.py")
    git("commit", "--message", "ours")
    found = manifest._git()
    assert found is not None
    assert not found["dirty"]

"""Spelling of documents and sources."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TEXTS = [
    "README.md", "CHANGELOG.md", "CONTRIBUTING.md", "docs", "swarm_envs", "discovery", "configs", "hero_robot", "firmware", "hardware",
    "tests",
]  # fmt: skip


def test_documents_and_sources_are_spelt_right(tmp_path: Path) -> None:
    if importlib.util.find_spec("codespell_lib") is None:
        pytest.skip("codespell is absent: pip install swarm-envs[docs]")
    command = [sys.executable, "-m", "codespell_lib"]
    ended = subprocess.run([*command, *TEXTS], cwd=ROOT, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stdout
    (tmp_path / "wrong.md").write_text("They " + "reci" + "eve it.\n")
    wrong = subprocess.run([*command, str(tmp_path / "wrong.md")], cwd=ROOT, capture_output=True, text=True, check=False)
    assert "==> receive" in wrong.stdout

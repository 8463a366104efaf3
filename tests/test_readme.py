"""What the README shows runs as shown."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

README = Path(__file__).parents[1] / "README.md"
SNIPPETS = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.DOTALL)


@pytest.mark.parametrize("number", range(len(SNIPPETS)))
def test_each_snippet_of_the_readme_runs(number: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    exec(compile(SNIPPETS[number], f"README snippet {number}", "exec"), names)
    if "picture" in names:
        assert names["picture"].shape == (426, 513, 3)  # type: ignore[attr-defined]
    if "runs" in names:
        assert names["runs"].poses.shape == (20, 601, 8, 3)  # type: ignore[attr-defined]
        assert (tmp_path / "swarm.gif").read_bytes().startswith(b"GIF89a")


def test_the_readme_has_both_snippets_and_links_that_lead_somewhere() -> None:
    assert len(SNIPPETS) == 2
    text = README.read_text(encoding="utf-8")
    for target in re.findall(r"\]\(([^)#]+)\)", text):
        assert target.startswith("http") or (README.parent / target).exists(), target

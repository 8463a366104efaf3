"""The study of wall following and milling: its command works."""

from __future__ import annotations

import pytest

from docs.studies.marked_page import between_marks
from docs.studies.wall_following_and_milling import study


def test_a_small_study_prints_a_row_for_each_world(capsys: pytest.CaptureFixture[str]) -> None:
    study.main(["--controllers", "4", "--print"])
    printed = capsys.readouterr().out
    for world in ("unrefined", "hero_plus", "hero_plus_frictionless", "authors_2024"):
        assert printed.count(f"| `{world}` |") == 3


def test_the_page_holds_the_tables_that_its_script_writes() -> None:
    table = between_marks(study.PAGE, "results")
    assert all(table.count(f"`{world.split(',')[0]}`") >= 3 for world in study.worlds())
    assert study.FIGURE.exists()

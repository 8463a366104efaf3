"""The study of wall following and milling: its intervals, and that its command works."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path
from types import ModuleType

import pytest

SCRIPT = Path(__file__).parents[1] / "docs" / "studies" / "wall_following_and_milling.py"


@pytest.fixture(scope="module")
def study() -> ModuleType:
    spec = importlib.util.spec_from_file_location(SCRIPT.stem, SCRIPT)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[SCRIPT.stem] = module
    spec.loader.exec_module(module)
    return module


def test_intervals_are_wilsons(study: ModuleType) -> None:
    # Newcombe (1998), Statistics in Medicine 17, 857-872, table I, method 3
    assert study.wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert study.wilson(15, 148) == pytest.approx((0.0624, 0.1605), abs=5e-5)
    assert study.wilson(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert study.wilson(1, 29) == pytest.approx((0.0061, 0.1718), abs=5e-5)


def test_a_small_study_prints_a_row_for_each_world(study: ModuleType, capsys: pytest.CaptureFixture[str]) -> None:
    study.main(["--controllers", "4", "--print"])
    printed = capsys.readouterr().out
    for world in ("unrefined", "hero_plus", "hero_plus_frictionless", "authors_2024"):
        assert printed.count(f"| `{world}` |") == 3


def test_the_page_holds_the_tables_that_its_script_writes(study: ModuleType) -> None:
    text = study.PAGE.read_text(encoding="utf-8")
    table = text.split("<!-- results -->\n")[1].split("<!-- end of results -->")[0]
    assert all(table.count(f"`{world.split(',')[0]}`") >= 3 for world in study.worlds())
    assert study.PAGE.with_suffix(".png").exists()

"""The docs: every picture and link exists, the numbers in them are the files' own."""

import re
from pathlib import Path

import pytest

from hardware.dimensions import hardware
from swarm_envs.worlds import load_world
from swarm_envs.worlds.geometry import start_points

HARDWARE = Path(__file__).parents[2] / "hardware"
PAGES = [HARDWARE / "README.md", *sorted((HARDWARE / "docs").glob("*.md"))]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_and_pictures_lead_somewhere(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#]+)[^)]*\)", page.read_text(encoding="utf-8")):
        if not target.startswith("http"):
            assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_every_picture_is_shown_and_all_are_small() -> None:
    text = "".join(page.read_text(encoding="utf-8") for page in PAGES)
    pictures = sorted((HARDWARE / "docs" / "images").glob("*.png"))
    assert [p.name for p in pictures if f"images/{p.name}" not in text] == []
    assert sum(p.stat().st_size for p in pictures) < 2_000_000


def test_the_start_grids_table_is_the_worlds() -> None:
    text = (HARDWARE / "docs" / "arena.md").read_text(encoding="utf-8")
    points = 1000 * start_points(load_world("hero_plus"))
    assert len(points) == 12
    for axis in (0, 1):
        for value in sorted({round(float(v), 2) for v in points[:, axis]}):
            assert f"{value:.2f}" in text


def test_the_wall_plan_in_the_docs_is_the_files() -> None:
    length, leg, long, short = hardware().wall_plan
    text = (HARDWARE / "docs" / "arena.md").read_text(encoding="utf-8")
    assert f"{length:.0f} mm" in text
    assert f"{leg:.0f} mm" in text
    assert f"{2 * (long + short)} segments" in text


def test_the_licence_is_the_verbatim_text() -> None:
    text = (HARDWARE / "LICENSE").read_text(encoding="utf-8")
    assert text.startswith("CERN Open Hardware Licence Version 2 - Weakly Reciprocal")
    assert "8.6 This Licence shall not be enforceable" in text

"""Results go between the marks of a page, and nothing else of it changes."""

from __future__ import annotations

from pathlib import Path

import pytest

from docs.studies.marked_page import between_marks, write_between_marks

PAGE = "# Page\n\n<!-- one -->\nold\n<!-- end -->\n\nmine\n\n<!-- two -->\n<!-- end -->\nlast\n"


def test_results_stand_between_their_marks_and_what_a_person_wrote_is_kept(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(PAGE)
    write_between_marks(page, {"two": "| b |\n", "one": "| a |"})
    assert page.read_text() == PAGE.replace("old", "| a |").replace("<!-- two -->\n", "<!-- two -->\n| b |\n")
    assert between_marks(page, "one") == "| a |\n"


@pytest.mark.parametrize("broken", ["<!-- one -->\n", "<!-- end -->"])
def test_a_page_without_a_mark_is_refused_and_left_as_it_is(tmp_path: Path, broken: str) -> None:
    page = tmp_path / "page.md"
    page.write_text(PAGE.replace(broken, ""))
    with pytest.raises(SystemExit, match=r"page\.md: has no lines <!-- one -->"):
        write_between_marks(page, {"one": "| a |"})
    assert page.read_text() == PAGE.replace(broken, "")

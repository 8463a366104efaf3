"""Pages that a person writes and a study fills: what stands between a mark and the next ``<!-- end -->`` is the study's."""

from __future__ import annotations

from pathlib import Path

END = "<!-- end -->"


def write_between_marks(page: Path, results: dict[str, str]) -> None:
    """Put each text between the line ``<!-- NAME -->`` of a page and the next line :data:`END`.

    Args:
        page: The page.
        results: Texts by the name of their mark.

    Raises:
        SystemExit: When a mark or its end is missing; the page is then as it was.
    """
    text = page.read_text(encoding="utf-8")
    for name, result in results.items():
        head, mark, rest = text.partition(f"<!-- {name} -->\n")
        _, end, tail = rest.partition(END)
        if not mark or not end:
            raise SystemExit(f"{page}: has no lines <!-- {name} --> and {END}, between which results are to stand; put them back")
        text = f"{head}{mark}{result.strip()}\n{end}{tail}"
    page.write_text(text, encoding="utf-8")


def between_marks(page: Path, name: str) -> str:
    """Return what stands between the mark ``<!-- NAME -->`` of a page and its end."""
    return page.read_text(encoding="utf-8").partition(f"<!-- {name} -->\n")[2].partition(END)[0]

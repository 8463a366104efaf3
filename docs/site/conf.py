"""How Sphinx builds the site."""

import os
import re
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT))

project = "Swarm Envs"
author = "The Swarm Envs authors"
copyright = "the Swarm Envs authors, Apache-2.0"
extensions = ["myst_parser", "sphinx_design", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
exclude_patterns = ["__pycache__"]
myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = "Swarm Envs"
html_static_path = ["_static", "../_build/static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_format = "short"
napoleon_google_docstring = True
python_display_short_literal_types = True

REACHABLE = [
    (r'<p class="caption" role="heading">', '<p class="caption" role="heading" aria-level="2">'),
    (r'<aside class="sidebar-drawer">', '<aside class="sidebar-drawer" aria-label="Site">'),
    (r'<aside class="toc-drawer([^"]*)">', r'<aside class="toc-drawer\1" aria-label="On this page">'),
    (r"<pre>", '<pre tabindex="0">'),
    (r'<div class="table-wrapper', '<div tabindex="0" class="table-wrapper'),
]
"""What the theme's pages lack for who cannot see or point: names, a level, and keys for what scrolls sideways."""


INCLUDED = re.compile(r"```\{include\} (\S+)\n```")
"""A page that is another file of the repository."""
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s#]+)(#[^)\s]*)?\)")


def file_of(page: Path) -> Path | None:
    """Return the file that a page shows, None for a page with a text of its own."""
    match = INCLUDED.fullmatch(page.read_text(encoding="utf-8").strip())
    return (page.parent / match[1]).resolve() if match else None


def show_file(app: Any, name: str, source: list[str]) -> None:
    """Put a file's text in its page's place; its links lead to pages of the site, and those out of it become words."""
    page = Path(app.srcdir) / f"{name}.md"
    file = file_of(page)
    if file is None:
        return
    pages = {shown: other for other in Path(app.srcdir).rglob("*.md") if (shown := file_of(other))}

    def lead(match: re.Match[str]) -> str:
        image, text, target, anchor = match.groups()
        if "://" in target:
            return match[0]
        there = (file.parent / target).resolve()
        if not image and there not in pages:
            return text or there.stem.replace("_", " ")
        return f"{image}[{text}]({os.path.relpath(pages.get(there, there), page.parent)}{anchor or ''})"

    source[0] = LINK.sub(lead, file.read_text(encoding="utf-8"))


def keep_signs(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Show |x| and a * b in docstrings as the mathematics that they are, not as markup."""
    lines[:] = [re.sub(r"(?<=\S )\*(?=[ =])", r"\\*", line.replace("|", "\\|")) for line in lines]


def make_reachable(app: Any, error: Exception | None) -> None:
    """Mend the written pages by :data:`REACHABLE`."""
    for page in Path(app.outdir).rglob("*.html") if error is None else []:
        text = page.read_text(encoding="utf-8")
        for theirs, ours in REACHABLE:
            text = re.sub(theirs, ours, text)
        page.write_text(text, encoding="utf-8")


def setup(app: Any) -> None:
    """Connect what this file adds to Sphinx."""
    app.connect("source-read", show_file)
    app.connect("build-finished", make_reachable)
    app.connect("autodoc-process-docstring", keep_signs, priority=400)

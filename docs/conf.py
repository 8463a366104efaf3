"""How Sphinx builds the site."""

import re
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from docs.site.quantities import declared  # noqa: E402  the repository is no installed package

project = "Swarm Envs"
author = "The Swarm Envs authors"
copyright = "the Swarm Envs authors, Apache-2.0"
extensions = ["myst_parser", "sphinx_design", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
exclude_patterns = ["_build", "playground", "site", "**/__pycache__"]
myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 3
html_theme = "furo"
html_title = "Swarm Envs"
html_static_path = ["_static", "_build/static"]
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
"""What the theme's pages lack for readers who use a screen reader or keys: names, a heading level, focus on what scrolls sideways."""


def keep_signs(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Show |x| and a * b in docstrings as the mathematics that they are, not as markup."""
    lines[:] = [re.sub(r"(?<=\S )\*(?=[ =])", r"\\*", line.replace("|", "\\|")) for line in lines]


def keep_sentences(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Put a field's sentence together again where napoleon took what stands before its colon for a type."""
    for place, line in enumerate(lines):
        if what == "attribute" and line.startswith(":type: "):
            lines[:] = [f"{line.removeprefix(':type: ')}: {lines[0]}", *lines[1:place], *lines[place + 1 :]]
            return


def tell_declaration(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Add a declared number's unit and bounds to its sentence."""
    if what == "attribute" and (told := declared(name)):
        lines += [told, ""]


def make_reachable(app: Any, error: Exception | None) -> None:
    """Mend the written pages by :data:`REACHABLE`."""
    for page in Path(app.outdir).rglob("*.html") if error is None else []:
        text = page.read_text(encoding="utf-8")
        for theirs, ours in REACHABLE:
            text = re.sub(theirs, ours, text)
        page.write_text(text, encoding="utf-8")


def setup(app: Any) -> None:
    """Connect what this file adds to Sphinx."""
    app.connect("build-finished", make_reachable)
    app.connect("autodoc-process-docstring", keep_signs, priority=400)
    app.connect("autodoc-process-docstring", keep_sentences, priority=600)  # after napoleon's 500
    app.connect("autodoc-process-docstring", tell_declaration, priority=700)

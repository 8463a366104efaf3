"""The site's generated pages, its presets, and its build."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import swarm_envs
from docs.site import generate
from swarm_envs import behaviours
from swarm_envs.envs.registration import ENVIRONMENTS

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
FIRST_VIEW = 1_000_000
"""Bytes that the front page may load before anyone scrolls."""


def test_committed_pages_are_what_the_generator_writes() -> None:
    pages = generate.pages()
    stale = [path for path, text in pages.items() if not (DOCS / path).exists() or (DOCS / path).read_text() != text]
    assert not stale, "run python -m docs.site.generate"
    on_disk = {f"{folder}/{path.name}" for folder in ("environments", "worlds") for path in (DOCS / folder).glob("*.md")}
    assert on_disk == set(pages) - {"atlas.md"}, "pages of environments or worlds that are gone"


def test_every_environment_has_every_section_of_its_docstring() -> None:
    expected = [
        "Description",
        "Action Space",
        "Observation Space",
        "Rewards",
        "Starting State",
        "Episode End",
        "Arguments",
        "Version History",
    ]
    for name in ENVIRONMENTS:
        headings = re.findall(r"^## (.+)$", (DOCS / f"environments/{generate.slug(name)}.md").read_text(), flags=re.MULTILINE)
        assert [heading for heading in headings if heading in expected] == expected


def test_every_sourced_number_of_a_world_is_in_its_table() -> None:
    for name in swarm_envs.world_names():
        world = swarm_envs.load_world(name)
        text = (DOCS / f"worlds/{name}.md").read_text()
        assert all(f"| `{path}` |" in text for path in world.provenance)


def test_presets_show_what_they_are_named_after() -> None:
    for preset in generate.PRESETS:
        runs = swarm_envs.rollouts(preset["world"], [preset["controller"]], seed=preset["seed"], threads=1)
        assert behaviours.label(runs) == [preset["behaviour"]], preset


def test_the_lock_file_names_the_public_registry_only() -> None:
    lock = json.loads((ROOT / "docs/playground/package-lock.json").read_text())
    resolved = [package["resolved"] for package in lock["packages"].values() if "resolved" in package]
    assert all(address.startswith("https://registry.npmjs.org/") for address in resolved)
    assert all("integrity" in package for name, package in lock["packages"].items() if name)


class Links(HTMLParser):
    """Collects where a page leads, what it loads, and its anchors."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loads: list[str] = []
        self.anchors: set[str] = set()
        self.without_alt: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        given = dict(attrs)
        self.anchors |= {value for value in (given.get("id"), given.get("name")) if value}
        if tag == "a" and given.get("href"):
            self.links.append(str(given["href"]))
        if tag == "link" and given.get("rel") in ("stylesheet", "icon") and given.get("href"):
            self.loads.append(str(given["href"]))
        if tag in ("script", "img", "source"):
            self.loads += [str(given[key]) for key in ("src", "srcset") if given.get(key)]
        if tag == "img" and not given.get("alt"):
            self.without_alt.append(str(given.get("src")))


def test_links_lead_somewhere_and_nothing_is_loaded_from_elsewhere(site: Path) -> None:
    pages = {path: Links(path.read_text()) for path in site.rglob("*.html")}
    broken = []
    for path, page in pages.items():
        for address in page.links + page.loads:
            if re.match(r"https?:|mailto:|data:", address):
                if address in page.loads:
                    broken.append(f"{path.name} loads {address}")
                continue
            name, _, anchor = address.partition("#")
            target = (path.parent / unquote(name.partition("?")[0])).resolve() if name else path
            lost = anchor and target in pages and "=" not in anchor and anchor not in pages[target].anchors
            if lost or not target.exists():
                broken.append(f"{path.relative_to(site)} -> {address}")
    assert not broken
    assert not [image for page in pages.values() for image in page.without_alt], "a picture without a text for who cannot see it"


def test_first_view_is_light_and_clips_are_small(site: Path) -> None:
    page = site / "index.html"
    files = {(page.parent / address.partition("?")[0]).resolve() for address in Links(page.read_text()).loads}
    assert sum(file.stat().st_size for file in files) + page.stat().st_size < FIRST_VIEW
    assert all(clip.stat().st_size < 100_000 for clip in (site / "_static" / "clips").glob("*.webp"))


def test_a_site_without_npm_says_how_to_get_it(tmp_path: Path) -> None:
    (tmp_path / "python").symlink_to(sys.executable)
    code = "from docs.site import build; build.build_playground()"
    ended = subprocess.run([sys.executable, "-c", code], cwd=ROOT, env={"PATH": str(tmp_path)}, capture_output=True, text=True, check=False)
    assert ended.returncode == 1
    assert "apt-get install npm" in ended.stderr

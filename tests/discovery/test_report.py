"""The report: one file that asks the network for nothing, and shows what the archive holds."""

import base64
import dataclasses
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import discovery
from discovery.report.archive_map import choose_rows, lay_out
from discovery.report.chart import line_chart
from discovery.report.page import SEARCHED
from discovery.rollouts.simulator import Simulator
from discovery.settings import SearchSettings
from swarm_envs.worlds import load_world


class Page(HTMLParser):
    """Collects tags, with their attributes, and the text of scripts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.scripts: dict[str | None, str] = {}
        self._script: str | None = None
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))
        if tag == "script":
            self._script = dict(attrs).get("id")

    def handle_data(self, data: str) -> None:
        if self.tags and self.tags[-1][0] == "script" and data.strip():
            self.scripts[self._script] = data

    def all(self, tag: str, **wanted: str) -> list[dict[str, str | None]]:
        return [given for name, given in self.tags if name == tag and all(given.get(key) == value for key, value in wanted.items())]


@pytest.fixture(scope="module")
def text(finished: Path) -> str:
    return (finished / "report.html").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def page(text: str) -> Page:
    return Page(text)


@pytest.fixture(scope="module")
def data(page: Page) -> Any:
    return json.loads(page.scripts["data"])


def test_it_asks_the_network_for_nothing(text: str, page: Page) -> None:
    written = text.replace(page.scripts["data"], "")  # base64 may hold anything
    assert not re.search(r"//\w", written), "an address in the page"
    assert "http:" not in text.lower()
    assert "https:" not in text.lower()
    assert "url(" not in text
    assert "@import" not in text
    for tag, given in page.tags:
        for key in ("src", "href", "action", "poster", "srcset", "data"):
            assert (given.get(key) or "data:").startswith(("data:", "#")), f"<{tag} {key}={given.get(key)}>"
    policy = page.all("meta", **{"http-equiv": "Content-Security-Policy"})
    assert policy[0]["content"].startswith("default-src 'none'")  # type: ignore[union-attr]


def test_it_says_who_searched(text: str) -> None:
    assert "Novelty search evaluated" in text
    methods = next(field.metadata["options"] for field in dataclasses.fields(SearchSettings) if field.name == "method")
    assert set(SEARCHED) == set(methods)


def test_it_is_small(text: str) -> None:
    assert len(text) < 3_000_000


def test_it_shows_ten_medoids_each_with_a_picture_its_numbers_and_its_label(finished: Path, text: str, page: Page, data: Any) -> None:
    medoids = discovery.load_run(finished).medoids
    assert len(page.all("article")) == len(data["rollouts"]) == len(medoids) == 10
    assert len(page.all("canvas", **{"class": "rollout"})) == 10
    for medoid in medoids:
        assert f'data-behaviour="{medoid.label}"' in text
        v0, w0, v1, w1 = medoid.controller
        for number in (f"{100 * v0:+.1f}", f"{w0:+.2f}", f"{100 * v1:+.1f}", f"{w1:+.2f}"):
            assert f"<td>{number.replace('-', chr(0x2212))}</td>" in text
    assert "v (cm/s)" in text
    assert "ω (rad/s)" in text
    assert "given by rules" in text


def test_every_picture_has_words_for_those_who_do_not_see_it(page: Page) -> None:
    for tag, given in page.tags:
        if tag == "canvas" or (tag == "svg" and given.get("aria-hidden") != "true"):
            assert given.get("role") == "img"
            assert given.get("aria-label")
    assert page.all("html", lang="en")


def test_the_animations_are_the_archives_own_rollouts(finished: Path, data: Any) -> None:
    run = discovery.load_run(finished)
    world, scene = load_world("hero_plus"), data["scene"]
    simulator = Simulator(world, "chipmunk", run.settings.steps, 1)
    for medoid, packed in zip(run.medoids, data["rollouts"], strict=True):
        generation = run.archive.generation == run.archive.generation[medoid.row]
        whole = simulator(run.archive.controllers[generation], int(run.archive.world_seed[medoid.row]))
        expected = whole.poses[run.archive.world_index[medoid.row], :: run.settings.report.frame_every]
        shown = np.frombuffer(base64.b64decode(packed["poses"]), "<i2").reshape(scene["frames"], scene["robots"], 3)
        assert np.allclose(shown[..., :2] / scene["length"] / scene["metre"], expected[..., :2], atol=1e-4)
        turn = shown[..., 2] / scene["angle"] - expected[..., 2]
        assert np.allclose((turn + np.pi) % (2 * np.pi), np.pi, atol=1e-3)


def test_how_to_repeat_it_is_there(text: str) -> None:
    assert "python" in text
    assert "-m discovery" in text
    assert "seed=0" in text
    assert "torch 2" in text
    assert "The encoder started from random weights, as asked" in text


def test_the_map_keeps_medoids_when_it_shows_a_part(data: Any) -> None:
    assert data["map"]["count"] == 20
    assert len(data["map"]["medoids"]) == 10
    rows = choose_rows(1000, np.array([3, 999, 500]), 50, 0)
    assert len(rows) == len(set(rows)) == 50
    assert {3, 500, 999} <= set(rows)


def test_the_map_takes_archives_of_any_size() -> None:
    for count in (1, 2, 3, 5):
        places = lay_out(np.random.default_rng(0).normal(size=(count, 8)).astype(np.float32), 250, 0)
        assert places.shape == (count, 2)
        assert np.all((places >= 0) & (places <= 1))


def test_a_chart_spans_its_values_and_needs_two() -> None:
    assert line_chart([1], [2.0], "", "", "") is None
    chart = line_chart([1, 2, 3], [4.5, 4.0, 3.7], "Training loss", "training step", "loss (nat)")
    assert chart is not None
    assert [float(text) for _, text in chart.y_ticks][-1] >= 4.5
    assert chart.path.count("L") == 2
    assert line_chart([1, 2], [3.0, 3.0], "", "", "") is not None

"""Maps of the test set: the files, and the page in headless Chromium."""

from __future__ import annotations

import base64
import csv
import json
import re
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from discovery.command import RunContext, run
from discovery.evaluation.command import main
from discovery.rollouts.simulator import Simulator
from discovery.rollouts.test_set import draw_test_set
from swarm_envs.worlds import load_world
from tests.browser import headless_chromium
from tests.discovery.tiny_run import tiny

pytestmark = pytest.mark.slow

AXE = Path(__file__).parents[2] / "docs" / "playground" / "node_modules" / "axe-core" / "axe.min.js"


@pytest.fixture(scope="module")
def maps(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of maps by two representations."""
    folder, paths = tmp_path_factory.mktemp("maps"), []
    for name in ("hand_crafted", "random"):
        paths.append(str(folder / name))
        run(tiny("steps=600", f"representation={name}", f"folder={paths[-1]}", simclr=False), given=True, context=RunContext())
    words = ["--per-class", "10", "--most-draws", "250", "--iterations", "250", "--threads", "1"]
    assert main(["tsne", *paths, "--out", str(folder / "out"), *words]) == 0
    return folder / "out"


@pytest.fixture(scope="module")
def data(maps: Path) -> Any:
    return json.loads(re.findall(r'<script id="data" type="application/json">(.*?)</script>', (maps / "tsne.html").read_text())[0])


def test_every_file_has_every_rollout_of_every_map(maps: Path, data: Any) -> None:
    told = json.loads((maps / "tsne.json").read_text())
    assert told["labels_given_by"] == "rules"
    assert [entry["representation"] for entry in told["maps"]] == ["hand-crafted", "random ResNet18"]
    count = sum(told["test_set"].values())
    assert count == 50, "ten of five classes, or more of those that there are"
    rows = list(csv.DictReader((maps / "tsne.csv").read_text().splitlines()))
    assert len(rows) == 2 * count
    assert len(data["rollouts"]) == len(base64.b64decode(data["labels"])) == count
    for entry in told["maps"]:
        places = np.array(entry["places"])
        assert places.shape == (count, 2)
        assert places.min() == 0.0
        assert places.max() == 1.0
    for ending in ("png", "svg"):
        assert (maps / f"tsne.{ending}").stat().st_size > 5000


def test_the_page_is_small_and_asks_the_network_for_nothing(maps: Path) -> None:
    text = (maps / "tsne.html").read_text()
    assert len(text) / 50 < 10_000, "500 rollouts stay below 5 MB"
    written = re.sub(r'<script id="data".*?</script>', "", text, flags=re.DOTALL)
    assert not re.search(r"//\w|url\(|@import", written.replace("// ", ""))
    assert "default-src 'none'" in text


def test_the_animations_are_the_last_half_of_the_labelled_rollouts(data: Any) -> None:
    simulator = Simulator(load_world("hero_plus"), "chipmunk", 600, 1)
    test = draw_test_set(simulator, 10, 250, 0)
    labels = [data["names"][code] for code in base64.b64decode(data["labels"])]
    assert labels == test.labels.tolist()
    scene = data["scene"]
    shown = np.frombuffer(base64.b64decode(data["rollouts"][3]["poses"]), "<i2").reshape(scene["frames"], scene["robots"], 3)
    expected = test.parts[0].poses[3, 300 :: round(scene["interval"] / 0.1)]
    np.testing.assert_allclose(shown[..., :2] / scene["length"] / scene["metre"], expected[..., :2], atol=1e-4)


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with headless_chromium(tmp_path_factory.mktemp("chromium"), "--window-size=1280,1000") as started:
        started.set_script_timeout(60)
        yield started


@pytest.fixture
def page(browser: Any, maps: Path) -> Iterator[Any]:
    browser.get((maps / "tsne.html").as_uri())
    yield browser
    logs = [entry for entry in browser.get_log("browser") if "favicon" not in entry["message"]]
    assert not logs, logs


def said(page: Any) -> str:
    return str(page.find_element("id", "shown").text)


def test_pointing_on_one_map_marks_all_and_plays(page: Any, data: Any) -> None:
    from selenium.webdriver import ActionChains

    canvas = page.find_elements("css selector", "[data-map]")[1]
    before = page.execute_script("return [...document.querySelectorAll('[data-map]')].map((each) => each.toDataURL())")
    x, y = page.execute_script("return maps.spot(1, 12)")
    size = canvas.size
    ActionChains(page).move_to_element_with_offset(canvas, round(x - size["width"] / 2), round(y - size["height"] / 2)).perform()
    row = page.execute_script("return maps.chosen()")
    there = page.execute_script("return maps.spot(1, arguments[0])", row)
    assert np.hypot(there[0] - x, there[1] - y) < 2, "another one may lie on top"
    assert said(page) == f"Rollout {row + 1} of 50: {data['names'][base64.b64decode(data['labels'])[row]]}"
    after = page.execute_script("return [...document.querySelectorAll('[data-map]')].map((each) => each.toDataURL())")
    assert all(a != b for a, b in zip(before, after, strict=True))
    first = page.execute_script("return [maps.time(), document.getElementById('rollout').toDataURL()]")
    deadline = time.monotonic() + 20
    while page.execute_script("return maps.time()") == first[0]:
        assert time.monotonic() < deadline, "it does not play"
    page.find_element("id", "play").click()
    assert page.execute_script("return document.getElementById('rollout').toDataURL()") != first[1]
    stopped = page.execute_script("return maps.time()")
    time.sleep(0.2)
    assert page.execute_script("return maps.time()") == stopped


def test_keys_alone_reach_other_rollouts(page: Any) -> None:
    canvas = page.find_element("css selector", "[data-map]")
    start = page.execute_script("return maps.spot(0, maps.chosen())")
    for key, axis, sign in (("\ue014", 0, 1), ("\ue015", 1, 1), ("\ue012", 0, -1), ("\ue013", 1, -1)):
        before = page.execute_script("return maps.spot(0, maps.chosen())")
        canvas.send_keys(key)
        now = page.execute_script("return maps.spot(0, maps.chosen())")
        assert now == before or sign * (now[axis] - before[axis]) > 0
    canvas.send_keys("\ue014", "\ue015", "\ue015")
    assert page.execute_script("return maps.spot(0, maps.chosen())") != start


def test_the_legend_counts_hides_and_skips(page: Any, data: Any) -> None:
    buttons = page.find_elements("css selector", "#legend button")
    labels = list(base64.b64decode(data["labels"]))
    assert [button.text for button in buttons] == [f"{name} {labels.count(code)}" for code, name in enumerate(data["names"])]
    for button in buttons[1:]:
        button.click()
        assert button.get_attribute("aria-pressed") == "false"
    canvas = page.find_element("css selector", "[data-map]")
    for key in "\ue014\ue015\ue012\ue013\ue014":
        canvas.send_keys(key)
    assert labels[page.execute_script("return maps.chosen()")] == 0


def test_who_asks_for_less_motion_sees_a_still_picture_and_nothing_is_out_of_reach(browser: Any, maps: Path) -> None:
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-reduced-motion", "value": "reduce"}]})
    try:
        browser.get((maps / "tsne.html").as_uri())
        assert browser.find_element("id", "play").text == "Play"
        still = browser.execute_script("return maps.time()")
        time.sleep(0.2)
        assert browser.execute_script("return maps.time()") == still
        if AXE.exists():
            browser.execute_script(AXE.read_text(encoding="utf-8"))
            check = "axe.run(document, {resultTypes: ['violations']}).then((r) => done(JSON.stringify(r.violations)))"
            told = json.loads(browser.execute_async_script(f"const done = arguments[0]; {check}"))
            worst = [f"{e['id']}: {e['nodes'][0]['html'][:120]}" for e in told if e["impact"] in ("serious", "critical")]
            assert not worst, worst
    finally:
        browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})

"""The behaviour atlas: its data, and the page in headless Chromium."""

from __future__ import annotations

import base64
import os
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import swarm_envs
from docs.site import atlas, atlas_data
from swarm_envs import behaviours

ROOT = Path(__file__).parents[2]
DATA = atlas_data.read()
LABELS = atlas_data.labels(DATA)


@pytest.fixture
def page(browser: Any, address: str) -> Any:
    browser.get("about:blank")
    browser.get(address + "atlas.html")
    return browser


def part(page: Any, name: str) -> Any:
    return page.find_element("css selector", f'#atlas [data-part="{name}"]')


def test_the_data_are_compact_and_whole() -> None:
    count = DATA["run"]["evaluations"]
    assert count >= 5_000
    assert atlas_data.DATA.stat().st_size < 500_000
    assert atlas_data.controllers(DATA).shape == (count, 4)
    assert len(LABELS) == len(base64.b64decode(DATA["places"])) // 4 == count
    assert len({medoid["row"] for medoid in DATA["medoids"]}) == 10
    assert abs(sum(medoid["share"] for medoid in DATA["medoids"]) - 1) < 1e-2


def test_labels_are_those_of_todays_simulation() -> None:
    rows = [medoid["row"] for medoid in DATA["medoids"]] + list(range(0, len(LABELS), len(LABELS) // 20))
    world, genes = DATA["run"]["world"], atlas_data.controllers(DATA)
    starts = []
    for row in rows:
        seed, index = atlas_data.start_of(DATA, row)
        starts.append(swarm_envs.rollouts(world, [[0, 0, 0, 0]] * (index + 1), seed=seed, steps=0, threads=1).poses[index, 0])
    runs = swarm_envs.rollouts(
        world, genes[rows], initial_poses=starts, engine=DATA["run"]["engine"], steps=DATA["run"]["steps"], threads=1
    )
    assert behaviours.label(runs) == [LABELS[row] for row in rows], "the worlds have changed: make the atlas from a new run"


def test_the_shown_command_repeats_the_run(page: Any, tmp_path: Path) -> None:
    button = page.find_elements("css selector", "#atlas [data-row]")[3]
    button.click()
    row = int(button.get_attribute("data-row"))
    assert part(page, "shown").text.startswith(LABELS[row])
    command = part(page, "command").get_attribute("textContent")
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    ended = subprocess.run(command, shell=True, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert ended.stdout == f"['{LABELS[row]}']\n", ended.stderr
    assert (tmp_path / "behaviour.gif").read_bytes().startswith(b"GIF89a")


def test_the_page_mostly_shows_what_the_label_says(page: Any) -> None:
    rows = [medoid["row"] for medoid in DATA["medoids"]]
    world = swarm_envs.load_world(DATA["run"]["world"])
    poses = np.array([page.execute_script("return window.atlas.run(arguments[0])", row) for row in rows])
    nothing, still = np.zeros(poses.shape[:3], np.uint8), np.zeros((*poses.shape[:3], 2))
    labels = behaviours.label(swarm_envs.Trajectories(world, "planck", np.arange(poses.shape[1]) * world.tick, poses, nothing, still))
    same = sum(label == LABELS[row] for label, row in zip(labels, rows, strict=True))
    assert same >= 7, labels


def test_pointing_plays_and_clicking_keeps(page: Any) -> None:
    from selenium.webdriver import ActionChains

    canvas, middle = part(page, "map"), page.execute_script("return window.atlas.map.canvas.clientWidth / 2")
    row = DATA["medoids"][1]["row"]
    x, y = page.execute_script("const m = window.atlas.map; return m.at(m.archive.place(arguments[0])).map((v) => v / m.density)", row)
    kept = part(page, "command").text
    ActionChains(page).move_to_element_with_offset(canvas, round(x - middle), round(y - middle)).perform()
    assert "click to keep" in part(page, "shown").text
    assert part(page, "command").text == kept
    ActionChains(page).click().perform()
    assert "click to keep" not in part(page, "shown").text
    assert part(page, "command").text != kept
    assert "rad/s" in part(page, "gene-3").text
    part(page, "open").click()
    assert f"#w={DATA['run']['world']}&" in page.current_url
    assert page.find_element("css selector", '#playground [data-part="world"]').get_attribute("value") == DATA["run"]["world"]


def test_the_map_is_worked_by_keys_alone(page: Any) -> None:
    canvas = part(page, "map")
    first = part(page, "command").text
    canvas.send_keys("\ue014")  # right
    second = part(page, "command").text
    assert second != first
    before = page.execute_script("return arguments[0].toDataURL()", canvas)
    canvas.send_keys("+")
    assert page.execute_script("return arguments[0].toDataURL()", canvas) != before
    canvas.send_keys("0")
    assert page.execute_script("return arguments[0].toDataURL()", canvas) == before


def test_the_legend_counts_and_hides(page: Any) -> None:
    counts = Counter(LABELS)
    buttons = page.find_elements("css selector", '#atlas [data-part="legend"] button')
    assert [button.text for button in buttons] == [f"{name} {counts[name]}" for name in DATA["labels"]]
    before = page.execute_script("return arguments[0].toDataURL()", part(page, "map"))
    buttons[-1].click()
    assert buttons[-1].get_attribute("aria-pressed") == "false"
    assert page.execute_script("return arguments[0].toDataURL()", part(page, "map")) != before


def test_a_folder_without_a_run_is_told_in_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("pyarrow")
    before = atlas_data.DATA.read_bytes()
    assert atlas.main([str(tmp_path / "nowhere")]) == 2
    assert atlas.main([]) == 2
    told = capsys.readouterr().err.splitlines()
    assert len(told) == 2
    assert "nowhere" in told[0]
    assert atlas_data.DATA.read_bytes() == before

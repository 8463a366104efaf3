"""The playground in headless Chromium, held to the Python simulation."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import swarm_envs
from swarm_envs import behaviours

GOLDEN = json.loads(Path(__file__).with_name("golden.json").read_text())
STEPS = 600


@pytest.fixture
def page(browser: Any, address: str) -> Any:
    browser.get("about:blank")
    browser.get_log("browser")  # what other pages had to say
    browser.get(address + "index.html")
    return browser


def run(page: Any, world: str, controller: list[float], poses: Any, steps: int = STEPS) -> np.ndarray:
    """Poses (steps + 1, robots, 3) of the page's own simulation."""
    script = "return JSON.stringify(window.playground.run(arguments[0], arguments[1], arguments[2], arguments[3]))"
    return np.array(json.loads(page.execute_script(script, world, controller, poses, steps)))


def part(page: Any, name: str) -> Any:
    return page.find_element("css selector", f'#playground [data-part="{name}"]')


def move_slider(page: Any, name: str, value: float) -> None:
    script = "arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event('input', {bubbles: true}))"
    page.execute_script(script, part(page, name), value)


def test_free_arcs_equal_pythons_to_a_millimetre_over_a_minute(page: Any) -> None:
    worst = 0.0
    for world, v, omega, start in [
        ("hero_plus", 0.09, 1.6, [0.85, 0.71, 0.3]),
        ("hero_plus", 0.05, 0.4, [0.85, 0.50, 0.0]),
        ("hero_plus", -0.01, 0.0, [0.3, 0.7, 3.0]),
        ("unrefined", 0.2, -3.0, [0.85, 0.71, 2.0]),
        ("unrefined", -0.2, 0.9, [0.85, 0.45, 3.1]),
        ("unrefined", 0.02, 1e-5, [0.2, 0.2, 0.5]),
    ]:
        controller = [v, omega, v, omega]
        expected = swarm_envs.rollouts(world, [controller], robots=1, initial_poses=[[start]], steps=STEPS, threads=1).poses[0]
        found = run(page, world, controller, [start])
        worst = max(worst, float(np.hypot(*(found - expected)[:, 0, :2].T).max()))
    print(f"worst deviation {1e3 * worst:.2g} mm")
    assert worst < 1e-3


def test_starts_are_pythons_to_the_bit(page: Any) -> None:
    for world, seed, index in [("hero_plus", 0, 0), ("hero_plus", 4_000_000_000, 7), ("unrefined", 12, 3)]:
        expected = swarm_envs.rollouts(world, [[0, 0, 0, 0]] * (index + 1), seed=seed, steps=0, threads=1).poses[index, 0]
        found = page.execute_script("return JSON.stringify(window.playground.start(...arguments))", world, 8, seed, index)
        assert json.loads(found) == expected.tolist()


def test_golden_runs_get_pythons_label(page: Any) -> None:
    same, other = 0, []
    for golden in GOLDEN:
        world = swarm_envs.load_world(golden["world"])
        poses = run(page, golden["world"], golden["controller"], golden["poses"])[None]
        nothing, still = np.zeros(poses.shape[:3], np.uint8), np.zeros((*poses.shape[:3], 2))
        runs = swarm_envs.Trajectories(world, "planck", np.arange(STEPS + 1) * world.tick, poses, nothing, still)
        (label,) = behaviours.label(runs)
        same += label == golden["label"]
        if label != golden["label"]:
            other.append((golden["world"], golden["controller"], golden["label"], label))
    print(f"{same} of {len(GOLDEN)} labels equal; {other}")
    assert len(GOLDEN) == 50
    assert same >= 45, other


def test_the_page_loads_nothing_from_elsewhere_and_reports_no_error(page: Any) -> None:
    loaded = page.execute_script("return performance.getEntriesByType('resource').map(r => r.name)")
    assert all(name.startswith(("http://127.0.0.1", "data:")) for name in loaded)
    assert not [entry for entry in page.get_log("browser") if entry["level"] == "SEVERE" and "favicon" not in entry["message"]]


def test_every_preset_runs_and_the_address_repeats_it(page: Any, address: str) -> None:
    presets = page.execute_script("return window.playground.data.presets")
    buttons = page.find_elements("css selector", "#playground [data-preset]")
    assert len(buttons) == len(presets) == 8
    for button, preset in zip(buttons, presets, strict=True):
        button.click()
        assert button.get_attribute("aria-pressed") == "true"
        assert f"w={preset['world']}&" in page.current_url
    shared = page.current_url
    page.get("about:blank")
    page.get(shared)
    pressed = page.find_elements("css selector", "#playground [aria-pressed=true]")
    assert [button.text for button in pressed] == ["wall following, unrefined"]
    page.get("about:blank")
    page.get(address + "index.html#w=nowhere&c=1,2&n=-3")
    assert part(page, "world").get_attribute("value") == "hero_plus"


def test_sliders_have_units_and_keep_to_the_worlds_limits(page: Any) -> None:
    move_slider(page, "v0", 0.05)
    assert part(page, "v0-value").text == "5.0 cm/s"
    move_slider(page, "w1", -9)
    assert part(page, "w1-value").text == "-1.60 rad/s"
    assert part(page, "w1").get_attribute("aria-valuetext") == "-1.60 rad/s"
    move_slider(page, "robots", 3)
    assert part(page, "seeing").text.endswith("of 3")


def test_robots_move_and_a_key_lifts_one(page: Any) -> None:
    canvas = part(page, "picture")
    before = page.execute_script("return arguments[0].toDataURL()", canvas)
    part(page, "run").click()
    paused = part(page, "time").text
    canvas.send_keys("n")
    canvas.send_keys("\ue014\ue014\ue014")
    assert page.execute_script("return arguments[0].toDataURL()", canvas) != before
    assert part(page, "time").text == paused
    assert part(page, "run").text == "Run"


def test_the_playground_fits_a_phone(page: Any) -> None:
    page.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True})
    try:
        page.refresh()
        wide = page.execute_script("return [document.documentElement.scrollWidth, window.innerWidth]")
        assert wide[0] <= wide[1]
    finally:
        page.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})

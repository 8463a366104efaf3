"""The live page in headless Chromium, against simulated robots."""

from __future__ import annotations

import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from hero_robot.fleet.simulated import SimulatedFleet
from tests.browser import headless_chromium
from tests.hero_robot.fleet.serving import CONTROLLER, PATIENCE, Serving, all_drive, stop_times, wait_for

pytestmark = pytest.mark.real_time


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    with headless_chromium(tmp_path_factory.mktemp("chromium")) as started:
        yield started


def state(browser: Any, robot: str) -> str:
    rows = browser.execute_script("return [...document.querySelectorAll('#robots tr')].map(r => [r.id, r.cells[1].textContent])")
    return str(dict(rows).get(robot, ""))


def row(browser: Any, robot: str) -> str:
    """Text of a robot's row; read at once, for the page writes its rows again ten times per second."""
    return str(browser.execute_script(f"return document.getElementById('{robot}').innerText"))


def states(browser: Any) -> set[str]:
    return {state(browser, f"hero_{number}") for number in range(1, 9)}


@pytest.fixture
def page(browser: Any, serving: Serving) -> Any:
    browser.get(serving.session["url"])
    wait_for(lambda: states(browser) == {"HOLD"}, PATIENCE, "the page to show eight robots in HOLD")
    browser.execute_script(
        "for (const kind of ['click', 'keydown']) document.addEventListener(kind, () => { window.pressed = Date.now(); }, true);"
    )
    return browser


def pressed_ns(page: Any) -> int:
    """When the page was told of the last press, on the robots' clock, ns: the way through the browser's driver is the test's own."""
    milliseconds = int(page.execute_script("return window.pressed"))
    return milliseconds * 1_000_000 - (time.time_ns() - time.monotonic_ns())


def stops_told_since_the_start(serving: Serving) -> int:
    events = serving.status()["events"]  # the newest twenty: eight robots start, and stop
    last = max(place for place, event in enumerate(events) if "RUN, started" in event)
    return sum("EMERGENCY STOP" in event for event in events[last:])


def load(serving: Serving) -> None:
    serving.call("update", controllers={f"hero_{number}": CONTROLLER for number in range(1, 9)})


def press(page: Any, selector: str) -> None:
    page.find_element("css selector", selector).click()


def test_the_big_button_stops_every_robot(page: Any, serving: Serving, robots: SimulatedFleet, tmp_path: Path) -> None:
    load(serving)
    press(page, "[data-post=start]")
    wait_for(lambda: all_drive(robots) and states(page) == {"RUN"}, PATIENCE, "all to run")
    assert page.save_screenshot(str(tmp_path / "running.png"))
    press(page, "#stop")
    assert max(stop_times(robots, pressed_ns(page))) < 0.5
    wait_for(lambda: states(page) == {"ESTOP"}, PATIENCE, "the page to say so")
    press(page, "[data-post=start]")
    wait_for(lambda: "rearm first" in page.find_element("id", "banner").text, PATIENCE, "the reason why not")
    press(page, "[data-post=rearm]")
    wait_for(lambda: states(page) == {"HOLD"}, PATIENCE, "HOLD")


def test_the_escape_key_stops_as_well(page: Any, serving: Serving, robots: SimulatedFleet) -> None:
    serving.start_all(robots)
    page.find_element("css selector", "body").send_keys("\ue00c")
    assert max(stop_times(robots, pressed_ns(page))) < 0.5
    wait_for(lambda: states(page) == {"ESTOP"}, PATIENCE, "the page to say so")
    time.sleep(0.5)  # the page asks again after 60 and 250 ms
    assert stops_told_since_the_start(serving) == 1, serving.status()["events"]


def test_the_stop_button_is_the_biggest_thing_and_in_sight(page: Any) -> None:
    for width, height in [(1280, 800), (400, 700)]:
        page.set_window_size(width, height)
        box = page.find_element("id", "stop").rect
        assert box["width"] > 0.8 * (width - 60)
        assert box["height"] > 90
        assert box["y"] + box["height"] < 400


def test_it_shows_what_each_robot_sees_and_which_is_away(page: Any, robots: SimulatedFleet) -> None:
    assert "3.70" in row(page, "hero_3")
    wait_for(lambda: "0.30 m" in row(page, "hero_3"), PATIENCE, "something before the sensor")
    robots.switch_off(3)
    wait_for(lambda: state(page, "hero_3") == "not connected", PATIENCE, "hero_3 to be missed")
    assert state(page, "hero_4") == "HOLD"
    for number in list(robots.processes):
        robots.switch_off(number)
    wait_for(lambda: states(page) == {"not connected"}, PATIENCE, "all to be missed")


def test_a_refused_controller_is_said_on_the_page(page: Any, serving: Serving) -> None:
    page.execute_script("post('update')")
    wait_for(lambda: "expected {'controllers'" in page.find_element("id", "banner").text, PATIENCE, "the reason")


def test_a_page_that_outlives_its_server_says_so_and_can_still_stop_the_next(page: Any, serving: Serving, robots: SimulatedFleet) -> None:
    port = serving.session["url"].rsplit(":", 1)[1]
    serving.kill()
    wait_for(lambda: "robots have stopped by themselves" in page.find_element("id", "banner").text, PATIENCE, "the warning")
    command, serving.command = serving.command, [*serving.command, "--page-port", port]
    try:
        serving.__enter__()
    finally:
        serving.command = command
    wait_for(lambda: states(page) == {"HOLD"}, PATIENCE, "the page to find the new server")
    serving.start_all(robots)

    def refused() -> bool:
        # pressed again each time: on a busy machine the warning that the server is silent may take the answer's place for a moment
        page.execute_script("document.querySelector('[data-post=rearm]').click()")
        time.sleep(0.2)
        return "earlier server" in page.find_element("id", "banner").text

    wait_for(refused, PATIENCE, "the old token to be refused")
    press(page, "#stop")
    assert max(stop_times(robots, pressed_ns(page))) < 0.5

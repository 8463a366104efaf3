"""Pages for everyone: axe-core finds nothing serious, keys reach everything, phones need not scroll sideways, little is loaded."""

from __future__ import annotations

import json
import time
from pathlib import Path
from typing import Any

import pytest

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
AXE = ROOT / "docs" / "playground" / "node_modules" / "axe-core" / "axe.min.js"
PAGES = ("index", "atlas", "environments/milling", "worlds/hero_plus", "guides/own_world")
"""One of each kind."""
LIGHT_ALONE = ("environments/index", "worlds/index", "studies/calibration_of_real_robots/index", "api", "design")
"""Pages made of the same parts."""
FIRST_VIEW = 1_000_000
"""Bytes that the front page may load before anyone scrolls."""


def media(browser: Any, **features: str) -> None:
    given = [{"name": name.replace("_", "-"), "value": value} for name, value in features.items()]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": given})


@pytest.fixture
def page(browser: Any, address: str) -> Any:
    """A function that opens a page of the site."""

    def open_page(name: str) -> Any:
        browser.get("about:blank")
        browser.get(f"{address}{name}.html")
        return browser

    yield open_page
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": []})
    browser.execute_cdp_cmd("Emulation.clearDeviceMetricsOverride", {})


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing_serious(page: Any, browser: Any, theme: str) -> None:
    # still pictures: what is measured shall not change meanwhile
    media(browser, prefers_color_scheme=theme, prefers_reduced_motion="reduce")
    axe, found = AXE.read_text(encoding="utf-8"), []
    for name in PAGES + (LIGHT_ALONE if theme == "light" else ()):
        page(name)
        browser.execute_script(axe)
        told = browser.execute_async_script(
            "const done = arguments[0]; axe.run(document, {resultTypes: ['violations']}).then((r) => done(JSON.stringify(r.violations)))"
        )
        for violation in json.loads(told):
            if violation["impact"] in ("serious", "critical"):
                found += [f"{name}: {violation['id']}: {node['html'][:120]}" for node in violation["nodes"]]
    assert not found, "\n".join(found)


def test_axe_would_find_a_picture_without_text(page: Any, browser: Any) -> None:
    page("design")
    browser.execute_script("document.querySelector('article').insertAdjacentHTML('beforeend', '<img src=\"x.png\">')")
    browser.execute_script(AXE.read_text(encoding="utf-8"))
    told = browser.execute_async_script("const done = arguments[0]; axe.run().then((r) => done(r.violations.map((v) => v.id)))")
    assert "image-alt" in told


def test_no_page_scrolls_sideways_on_a_phone(page: Any, browser: Any, site: Path) -> None:
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": 360, "height": 740, "deviceScaleFactor": 2, "mobile": True})
    wide = []
    written = [*site.glob("*.html"), *(site / "guides").glob("*.html"), *(site / "studies").rglob("*.html")]
    names = {str(path.relative_to(site).with_suffix("")) for path in written}
    for name in sorted(names | set(PAGES + LIGHT_ALONE)):
        if name not in ("genindex", "py-modindex", "search"):
            page(name)
            width = browser.execute_script("return document.documentElement.scrollWidth")
            if width > 360:
                wide.append((name, width))
    assert not wide


@pytest.mark.parametrize("name", ["index", "atlas", "worlds/hero_plus"])
def test_no_page_scrolls_sideways_on_a_screen(page: Any, browser: Any, name: str) -> None:
    page(name)
    assert browser.execute_script("return document.documentElement.scrollWidth <= innerWidth")


@pytest.mark.parametrize("name", ["index", "atlas"])
def test_tab_reaches_every_control(page: Any, browser: Any, name: str) -> None:
    from selenium.webdriver import ActionChains

    page(name)
    root = "#playground" if name == "index" else "#atlas"
    controls = f"{root} :is(button, input, select, canvas[tabindex], a, pre[tabindex])"
    browser.execute_script(f"document.querySelector('{controls}').focus()")
    reached = 1
    for _ in range(100):
        ActionChains(browser).send_keys("\ue004").perform()
        if not browser.execute_script(f"return document.activeElement.matches('{controls}')"):
            break
        outline = browser.execute_script("return getComputedStyle(document.activeElement).outlineWidth")
        assert outline == "3px"
        reached += 1
    assert reached == len(browser.find_elements("css selector", controls)) > 15


def test_the_first_view_is_light_and_from_this_site_alone(page: Any, browser: Any, address: str) -> None:
    browser.execute_cdp_cmd("Network.enable", {})
    browser.execute_cdp_cmd("Network.setCacheDisabled", {"cacheDisabled": True})
    try:
        page("index")
        time.sleep(1)
        kinds = "['navigation', 'resource'].flatMap((kind) => performance.getEntriesByType(kind))"
        loaded = browser.execute_script(f"return {kinds}.map((entry) => [entry.name, entry.transferSize])")
    finally:
        browser.execute_cdp_cmd("Network.setCacheDisabled", {"cacheDisabled": False})
    total = sum(size for _, size in loaded)
    print(f"first view: {total} bytes in {len(loaded)} files")
    assert all(name.startswith((address, "data:")) for name, _ in loaded)
    assert any("playground.js" in name and size > 100_000 for name, size in loaded)
    assert total < FIRST_VIEW

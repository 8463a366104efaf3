"""The built site and a browser that looks at it, once for all tests of a worker."""

from __future__ import annotations

import importlib.util
import shutil
import subprocess
import sys
import threading
from collections.abc import Iterator
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import pytest

from tests.browser import headless_chromium
from tests.made_once import made_once

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="session")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of HTML; workers take turns, and all but the first find it built."""
    if shutil.which("npm") is None or importlib.util.find_spec("sphinx") is None:
        pytest.skip("npm or sphinx is absent (Debian: npm; pip install swarm-envs[docs])")

    def build(_: Path) -> None:
        ended = subprocess.run([sys.executable, "docs/site/build.py"], cwd=ROOT, capture_output=True, text=True, check=False)
        assert ended.returncode == 0, ended.stdout + ended.stderr

    made_once(tmp_path_factory, "site", build)
    return ROOT / "docs" / "_build" / "html"


class Quiet(SimpleHTTPRequestHandler):
    """Serves the site without a line for every file."""

    def log_message(self, format: str, *args: Any) -> None:
        del format, args


@pytest.fixture(scope="session")
def address(site: Path) -> Iterator[str]:
    """Where the site is served, with a slash at the end."""
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(Quiet, directory=str(site))) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}/"
        server.shutdown()


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """A browser window of 1280 x 1000 pixels; closed after each file, since a page's swarm that runs on takes most of a core."""
    with headless_chromium(tmp_path_factory.mktemp("chromium"), "--window-size=1280,1000") as started:
        started.set_script_timeout(120)
        yield started

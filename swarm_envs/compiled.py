"""``@compiled``: numba with a cache that cannot be stale, and a line that says when it compiles.

numba caches a function by its own file's date and does not notice when a function that it calls has changed in another file.
Here the cache's folder is named after the contents of the sources that a function may call: those of the simulation and of its own room,
the folder of the package that it lies in, with all folders inside. Any edit or upgrade of them compiles again.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

import numba
from numba.core import event

F = TypeVar("F", bound=Callable[..., Any])

PACKAGE = Path(__file__).parent
SIMULATION = PACKAGE / "simulation"
ENGINE_SECONDS = 20
"""How many seconds the compilation of an engine may take."""
FIRST_USE = {
    SIMULATION: f"first use: what is run is compiled before, up to {ENGINE_SECONDS} seconds for an engine, once",
    PACKAGE: "compiling metrics and behaviours on first use; up to 10 seconds, once",
    PACKAGE / "calibration": "compiling the calibration's filter on first use; up to 20 seconds, once",
    PACKAGE / "envs": "compiling the tasks' rewards on first use; up to 10 seconds, once",
    PACKAGE / "rendering": "compiling rendering on first use; up to 10 seconds, once",
}
"""What is said when the first function of a room is compiled. Of the simulation that is when it is imported, before anything slow."""
UNUSED_DAYS = 14
"""Caches that no process opened for so long are removed; another version in use beside this one keeps its own."""


def compiled(*signature: str, **options: Any) -> Callable[[F], F]:
    """Decorate a function to be compiled on first use, without the interpreter's lock, and cached on disk.

    Args:
        signature: The types of the result and the arguments where only one set of them is to be compiled, at import; several
            would be for callers that pass a constant, an index and a number.
        **options: Passed to :func:`numba.njit`, such as ``forceinline``; ``_nrt=False`` for functions that create no array:
            numba then counts no references, which costs more than the physics where a loop looks at an array's rows.
    """

    def decorate(function: F) -> F:
        with caching_in(cache_folder(room_of(Path(function.__code__.co_filename)))):
            return numba.njit(*signature, cache=True, nogil=True, **{"_nrt": True} | options)(function)  # type: ignore[no-any-return]

    return decorate


@contextmanager
def caching_in(folder: Path) -> Iterator[None]:
    """Let numba's decorators put their caches into a folder."""
    before = numba.config.CACHE_DIR
    numba.config.CACHE_DIR = str(folder)
    try:
        yield
    finally:
        numba.config.CACHE_DIR = before


def room_of(source: Path) -> Path:
    """Return the room of a source file: the folder of this package that holds it, however deep; the package for a file beside them.

    The room of a file outside the package is its own folder.
    """
    if not source.is_relative_to(PACKAGE):
        return source.parent
    inside = source.relative_to(PACKAGE).parts
    return PACKAGE / inside[0] if len(inside) > 1 else PACKAGE


def sources(room: Path) -> list[Path]:
    """Return the files that functions of a room may be compiled from: the simulation's and the room's, in a fixed order."""
    own = room.glob("*.py") if room == PACKAGE else room.rglob("*.py")
    return list(dict.fromkeys([*sorted(SIMULATION.rglob("*.py")), *sorted(own)]))


@cache
def cache_folder(room: Path = SIMULATION) -> Path:
    """Return the folder of compiled code for the present sources of a room and the simulation, and this numba.

    It is ``swarm_envs`` in the user's cache folder (or in ``NUMBA_CACHE_DIR``), else in the temporary folder.
    """
    digest = hashlib.sha256(f"{numba.__version__} {sys.version}".encode())
    for source in sources(room):
        digest.update(source.read_bytes())
    name = digest.hexdigest()[:16]
    base = os.environ.get("NUMBA_CACHE_DIR") or os.path.join(os.environ.get("XDG_CACHE_HOME") or "~/.cache", "swarm_envs")
    for root in (Path(base).expanduser(), Path(tempfile.gettempdir()) / f"swarm_envs_{os.getuid() if hasattr(os, 'getuid') else 0}"):
        try:
            (root / name).mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryFile(dir=root / name):
                pass
        except OSError:
            continue
        os.utime(root / name)
        _forget_unused(root)
        return root / name
    return Path(tempfile.mkdtemp(prefix="swarm_envs_"))


def announce(line: str, room: Path = SIMULATION) -> None:
    """Write a line to stderr, once for each state of a room's sources."""
    marker = cache_folder(room) / f"announced-{hashlib.sha256(line.encode()).hexdigest()[:8]}"
    with suppress(FileExistsError):
        marker.parent.mkdir(parents=True, exist_ok=True)
        marker.touch(exist_ok=False)  # of several threads or processes one speaks
        print(f"swarm_envs: {line}", file=sys.stderr, flush=True)


class _Announcer(event.Listener):  # type: ignore[misc]  # numba carries no types
    """Announces a room when its first function is compiled; one that comes from the cache is not."""

    def on_start(self, event: Any) -> None:
        """Told by numba before it compiles."""
        room = room_of(Path(event.data["dispatcher"].py_func.__code__.co_filename))
        if room in FIRST_USE:
            announce(FIRST_USE[room], room)

    def on_end(self, event: Any) -> None:
        """Told by numba after it has compiled."""


event.register("numba:compile", _Announcer())


def _forget_unused(root: Path) -> None:
    """Remove the caches of sources that nobody runs any more."""
    oldest = time.time() - UNUSED_DAYS * 86400
    for path in root.iterdir():
        with suppress(OSError):  # another process may be doing the same
            if path.is_dir() and len(path.name) == 16 and path.stat().st_mtime < oldest:
                shutil.rmtree(path, ignore_errors=True)

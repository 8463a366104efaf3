"""``@compiled``: numba with a cache that cannot be stale.

numba caches a function by its own file's date and does not notice when a function that it calls has changed in another file.
Here the cache's folder is named after the contents of the sources that a function may call: those of its own folder and of the
simulation. Any edit or upgrade of them compiles anew.
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

F = TypeVar("F", bound=Callable[..., Any])

SIMULATION = Path(__file__).parent / "simulation"
UNUSED_DAYS = 14
"""Caches that no process opened for so long are removed; another version in use beside this one keeps its own."""


def compiled(*signature: str, **options: Any) -> Callable[[F], F]:
    """Decorate a function to be compiled on first use, without the interpreter's lock, and cached on disk.

    Args:
        signature: The types of the result and the arguments where only one set of them shall be compiled, at import; several
            would be for callers that pass a constant, an index and a number.
        **options: Passed to :func:`numba.njit`, such as ``forceinline``; ``_nrt=False`` for functions that create no array:
            numba then counts no references, which costs more than the physics where a loop looks at an array's rows.
    """

    def decorate(function: F) -> F:
        with caching_in(cache_folder(Path(function.__code__.co_filename).parent)):
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


@cache
def cache_folder(package: Path = SIMULATION) -> Path:
    """Return the folder of compiled code for the present sources of a package folder and the simulation, and this numba.

    It is ``swarm_envs`` in the user's cache folder (or in ``NUMBA_CACHE_DIR``), else in the temporary folder.
    """
    digest = hashlib.sha256(f"{numba.__version__} {sys.version}".encode())
    for source in [*sorted(SIMULATION.glob("*.py")), *sorted(package.glob("*.py"))]:
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


def announce_compilation(engine: str, *asked: bool | None) -> None:
    """Say in one line, once per state of the sources, that the first use of an engine compiles it, with what is asked for."""
    marker = cache_folder() / "-".join(["announced", engine, *("with" if each else "without" for each in asked)])
    if not marker.exists():
        print(f"swarm_envs: compiling the {engine} engine on first use; up to twenty seconds, once", file=sys.stderr, flush=True)
        marker.parent.mkdir(parents=True, exist_ok=True)
        marker.touch()


def _forget_unused(root: Path) -> None:
    """Remove the caches of sources that nobody runs any more."""
    oldest = time.time() - UNUSED_DAYS * 86400
    for path in root.iterdir():
        with suppress(OSError):  # another process may be doing the same
            if path.is_dir() and len(path.name) == 16 and path.stat().st_mtime < oldest:
                shutil.rmtree(path, ignore_errors=True)

"""What is made once for a whole run of the tests, though several processes (pytest-xdist's workers) run them."""

from __future__ import annotations

import fcntl
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest


def made_once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], None]) -> Path:
    """Return a folder that ``make`` has filled: the first process that asks makes it, the others wait for it and find it.

    Args:
        factory: pytest's ``tmp_path_factory``; the folder lies in this run's temporary folder.
        name: The folder's name, of one meaning in the whole suite.
        make: Fills the empty folder that it is given. Where it fails or skips, the next process tries again.
    """
    base = factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        base = base.parent  # the workers' own folders lie side by side in the run's
    folder, made = base / name, base / f"{name}.made"
    with (base / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not made.exists():
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            make(folder)
            made.touch()
    return folder

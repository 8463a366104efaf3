"""How the suite shares a machine: one core for each worker, long files first, and no import of files that are not asked for.

``make test`` runs the files on one worker for each core (``--dist loadfile --no-loadscope-reorder``): a file's tests stay in one worker,
so that what its fixtures make is made once, and workers take the files in the order of collection.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

if "PYTEST_XDIST_WORKER" in os.environ:
    # Libraries start a thread for each core, and threads that wait for each other spin: with one worker for each core that took up to
    # twenty times as long. Read when a library is loaded, so it stands before all imports; tests of threads ask for them by number.
    for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ.setdefault(variable, "1")


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put files with a test marked slow first: a long file that begins last would leave the other cores idle at the end."""
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Where one marker alone is asked for (``-m real_time``), pass over files that do not name it: importing all takes 20 s."""
    wanted = config.option.markexpr
    if re.fullmatch(r"\w+", wanted) and collection_path.name.startswith("test_") and collection_path.suffix == ".py":
        return True if wanted not in collection_path.read_text(encoding="utf-8") else None
    return None

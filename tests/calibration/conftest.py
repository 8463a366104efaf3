"""The guide's example, calibrated once for all tests that look at it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.calibration.guide import bash, python
from tests.made_once import made_once


@pytest.fixture(scope="session")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the log of the guide's first snippet was calibrated by its second."""

    def make(folder: Path) -> None:
        with pytest.MonkeyPatch.context() as patch:
            patch.chdir(folder)
            python(0)
            bash(0)

    return made_once(tmp_path_factory, "guide", make)

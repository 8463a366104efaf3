from __future__ import annotations

import shutil

import pytest

KEY = bytes(range(32))


@pytest.fixture(scope="session", autouse=True)
def compiler() -> None:
    pytest.importorskip("cffi", reason="cffi is absent: pip install cffi")
    if not any(shutil.which(name) for name in ("cc", "gcc", "clang")):
        pytest.skip("no C compiler (Debian: gcc)")

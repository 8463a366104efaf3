"""The examples in the public API's docstrings run as shown."""

from __future__ import annotations

import doctest
import importlib
from types import ModuleType

import pytest

PUBLIC = ("swarm_envs", "swarm_envs.worlds.load", "swarm_envs.behaviours", "swarm_envs.metrics")


@pytest.mark.parametrize("name", PUBLIC)
def test_examples_run_as_shown(name: str) -> None:
    module: ModuleType = importlib.import_module(name)
    result = doctest.testmod(module)
    assert result.attempted >= 3
    assert result.failed == 0

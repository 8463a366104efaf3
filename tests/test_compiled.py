"""The cache of compiled code is never stale, and whoever waits for the compiler is told so."""

from __future__ import annotations

import importlib
import os
import pkgutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest
from numba.core.registry import CPUDispatcher

import swarm_envs
from swarm_envs import compiled


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package with a file of its own, a simulation and one more room, each with a folder inside."""
    for name in ("metrics.py", "simulation/stepping.py", "simulation/disc/solver.py", "rendering/raster.py", "rendering/film/gif.py"):
        source = tmp_path / "package" / name
        source.parent.mkdir(parents=True, exist_ok=True)
        source.write_text(f"# {name}\n", encoding="utf-8")
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr(compiled, "PACKAGE", tmp_path / "package")
    monkeypatch.setattr(compiled, "SIMULATION", tmp_path / "package" / "simulation")
    return tmp_path / "package"


def folders(package: Path) -> dict[str, Path]:
    """The cache of each source, as a new process would find it."""
    compiled.cache_folder.cache_clear()
    return {str(p.relative_to(package)): compiled.cache_folder(compiled.room_of(p)) for p in package.rglob("*.py")}


def test_an_edit_in_a_room_compiles_that_room_again_and_no_other(package: Path) -> None:
    before = folders(package)
    (package / "rendering/film/gif.py").write_text("# changed\n", encoding="utf-8")
    after = folders(package)
    assert {name for name in before if before[name] != after[name]} == {"rendering/raster.py", "rendering/film/gif.py"}


def test_an_edit_anywhere_in_the_simulation_compiles_everything_again(package: Path) -> None:
    before = folders(package)
    (package / "simulation/disc/solver.py").write_text("# changed\n", encoding="utf-8")
    after = folders(package)
    assert not [name for name in before if before[name] == after[name]]


def modules() -> Iterator[ModuleType]:
    for found in pkgutil.walk_packages(swarm_envs.__path__, "swarm_envs."):
        if not found.name.endswith("__main__"):
            yield importlib.import_module(found.name)


def callees(function: CPUDispatcher) -> Iterator[CPUDispatcher]:
    """Compiled functions that a compiled one names, as a name of its module or as ``module.name``."""
    names, known = function.py_func.__code__.co_names, function.py_func.__globals__
    for value in (known[name] for name in names if name in known):
        holders = [getattr(value, name, None) for name in names] if isinstance(value, ModuleType) else [value]
        yield from (held for held in holders if isinstance(held, CPUDispatcher))


def test_compiled_functions_call_only_those_of_their_own_room_or_the_simulation() -> None:
    """What the cache's key rests on."""
    functions = {value for module in modules() for value in vars(module).values() if isinstance(value, CPUDispatcher)}
    assert len(functions) > 100
    calls = [(caller, callee) for caller in functions for callee in callees(caller)]
    assert len(calls) > 100
    for caller, callee in calls:
        allowed = compiled.sources(compiled.room_of(Path(caller.py_func.__code__.co_filename)))
        assert Path(callee.py_func.__code__.co_filename) in allowed, f"{caller} calls {callee}"


SCRIPT = "import swarm_envs; swarm_envs.metrics.nearest_distances([[0.0, 0.0], [3.0, 4.0]])"


def test_the_first_use_says_that_it_compiles_and_the_second_is_silent(tmp_path: Path) -> None:
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}
    first, second = (
        subprocess.run([sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, check=True).stderr for _ in range(2)
    )
    said = [line for line in first.splitlines() if line.startswith("swarm_envs: ")]
    assert said == [
        "swarm_envs: first use: what is run is compiled before, up to 20 seconds for an engine, once",
        "swarm_envs: compiling metrics and behaviours on first use; up to 10 seconds, once",
    ]
    assert "swarm_envs: " not in second

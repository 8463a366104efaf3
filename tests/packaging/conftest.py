"""What a user installs: sdist and wheel as ``python -m build`` makes them, and virtual environments with nothing but the wheel."""

from __future__ import annotations

import functools
import os
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.made_once import made_once

ROOT = Path(__file__).parents[2]
QUIET = ("--quiet", "--disable-pip-version-check")
PIP = (sys.executable, "-m", "pip")


def outside_environment() -> dict[str, str]:
    """The variables of a process that knows nothing of the checkout."""
    return {name: text for name, text in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}


def call(*words: str | Path, cwd: Path, **environment: str) -> subprocess.CompletedProcess[str]:
    """Call a program away from the checkout, with no path into it."""
    environment = outside_environment() | environment
    return subprocess.run(
        [str(word) for word in words],
        cwd=cwd,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


def must(*words: str | Path, cwd: Path, **environment: str) -> str:
    """Call a program that is expected to succeed; what it printed."""
    done = call(*words, cwd=cwd, **environment)
    assert done.returncode == 0, f"{' '.join(map(str, words))}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def interpreters() -> dict[str, str]:
    """The interpreters on this machine that the project supports, by version: this one, those on the path and pyenv's."""
    found = {f"{sys.version_info.major}.{sys.version_info.minor}": sys.executable}
    pyenv = Path(os.environ.get("PYENV_ROOT") or Path.home() / ".pyenv") / "versions"
    for version in ("3.11", "3.12", "3.13"):
        candidates = [shutil.which(f"python{version}"), *sorted(map(str, pyenv.glob(f"{version}.*/bin/python")), reverse=True)]
        for candidate in filter(None, candidates):
            asked = subprocess.run(
                [candidate, "-c", "import sys, venv; print('%d.%d' % sys.version_info[:2])"], capture_output=True, text=True, check=False
            )
            if asked.returncode == 0 and asked.stdout.strip() == version:  # pyenv's links may lead to no version that is set
                found.setdefault(version, candidate)
                break
    return dict(sorted(found.items()))


@functools.cache
def registry_is_reached() -> bool:
    asked = [*PIP, "install", *QUIET, "--dry-run", "--ignore-installed", "--no-deps", "--retries", "1", "--timeout", "10", "setuptools"]
    return subprocess.run(asked, capture_output=True, check=False).returncode == 0


@pytest.fixture(scope="session")
def registry() -> None:
    if not registry_is_reached():
        pytest.skip("the package registry cannot be reached: nothing can be built or installed from it")


@pytest.fixture(scope="session")
def sources(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A copy of the files that git knows or would take, as a fresh clone holds them; builds leave nothing in the checkout."""
    if not (ROOT / ".git").exists() or shutil.which("git") is None:
        pytest.skip("git is absent, or this is no checkout: which files belong to the project is not known")

    def copy(folder: Path) -> None:
        listed = must("git", "ls-files", "-z", "--cached", "--others", "--exclude-standard", cwd=ROOT).split("\0")
        for name in filter(None, listed):
            if os.path.lexists(ROOT / name):  # one that was removed and not committed is still listed
                (folder / name).parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(ROOT / name, folder / name, follow_symlinks=False)

    return made_once(tmp_path_factory, "sources", copy)


@pytest.fixture(scope="session")
def built(tmp_path_factory: pytest.TempPathFactory, sources: Path, registry: None) -> Path:
    """A folder with the sdist, and the wheel that was built from it."""

    def build(folder: Path) -> None:
        must(sys.executable, "-m", "build", "-o", folder, ".", cwd=sources)

    return made_once(tmp_path_factory, "dist", build)


@pytest.fixture(scope="session")
def wheel(built: Path) -> Path:
    (found,) = built.glob("*.whl")
    return found


@pytest.fixture(scope="session")
def sdist(built: Path) -> Path:
    (found,) = built.glob("*.tar.gz")
    return found


@dataclass(frozen=True)
class InstalledWheel:
    """A virtual environment with the wheel.

    Attributes:
        folder: The environment's.
        path: What is looked for where the environment lacks it, as ``PYTHONPATH``; empty for nothing.
    """

    folder: Path
    path: str = ""

    def environment(self) -> dict[str, str]:
        return {"NUMBA_CACHE_DIR": str(self.folder / "compiled"), **({"PYTHONPATH": self.path} if self.path else {})}

    def run(self, command: str, *words: str, cwd: Path) -> str:
        return must(self.folder / "bin" / command, *words, cwd=cwd, **self.environment())

    def start(self, command: str, *words: str, cwd: Path, **environment: str) -> subprocess.Popen[str]:
        words = (str(self.folder / "bin" / command), *words)
        environment = outside_environment() | self.environment() | environment
        return subprocess.Popen(words, cwd=cwd, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


@pytest.fixture(scope="session")
def installed(tmp_path_factory: pytest.TempPathFactory, wheel: Path) -> Callable[[str], InstalledWheel]:
    """Given an interpreter's version, a virtual environment of it with the wheel and the base dependencies alone."""

    def install(version: str) -> InstalledWheel:
        def make(folder: Path) -> None:
            must(interpreters()[version], "-m", "venv", "--without-pip", folder, cwd=folder)
            python = folder / "bin" / "python"
            # pip outside installs into it; compiling what nothing imports would take longest
            must(*PIP, "--python", python, "install", *QUIET, "--no-compile", wheel, cwd=folder)

        return InstalledWheel(made_once(tmp_path_factory, f"venv-{version}", make))

    return install


@pytest.fixture(scope="session")
def with_extras(installed: Callable[[str], InstalledWheel], tmp_path_factory: pytest.TempPathFactory) -> InstalledWheel:
    """The wheel with what its extras need.

    Their libraries take 3 GB and are not installed a second time: commands and packages are the wheel's own and come first, and what they
    import beside the base dependencies is found in the environment that runs the tests.
    """
    bare = installed(f"{sys.version_info.major}.{sys.version_info.minor}")
    own = bare.run("python", "-c", "import sysconfig; print(sysconfig.get_path('purelib'))", cwd=tmp_path_factory.getbasetemp()).strip()
    place = InstalledWheel(bare.folder, os.pathsep.join([own, sysconfig.get_path("purelib"), sysconfig.get_path("platlib")]))
    for package in ("swarm_envs", "discovery", "hero_robot"):
        found = place.run("python", "-c", f"import {package}; print({package}.__file__)", cwd=tmp_path_factory.getbasetemp())
        assert Path(found.strip()).is_relative_to(bare.folder)
    return place

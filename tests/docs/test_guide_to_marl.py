"""The snippets of the guide to BenchMARL and RLlib run as shown, each with the versions of packages that its library takes.

``make guide-packages`` installs what differs from the tests' environment; it is found before the environment's own.
"""

from __future__ import annotations

import math
import re
import sys
from importlib.metadata import Distribution, distributions
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.docs.test_guides import PAGES, ROOT, run, snippets

pytestmark = pytest.mark.slow

LIBRARIES = {"benchmarl": ("benchmarl", ""), "rllib": ("ray", "rllib")}
"""Package and extra of each library of the guide."""


def pinned(library: str) -> dict[str, str]:
    """Versions by package, as the file says."""
    lines = (ROOT / "tests" / "docs" / "packages" / f"{library}.txt").read_text(encoding="utf-8").splitlines()
    return {canonicalize_name(name): version for name, version in (line.split("==") for line in lines if not line.startswith("#"))}


def packages(library: str) -> Path:
    """The folder that holds them."""
    folder = Path(sys.prefix) / "guides" / library
    if not (folder / "installed").exists():
        pytest.skip(f"{folder} is absent: install what the guide to {library} needs with make guide-packages")
    return folder


def by_name(found: list[Distribution]) -> dict[str, Distribution]:
    return {canonicalize_name(each.metadata["Name"]): each for each in found}


@pytest.mark.parametrize("library", LIBRARIES)
def test_the_snippet_of_the_guide_runs(library: str, tmp_path: Path) -> None:
    imported = f"from {LIBRARIES[library][0]}."
    (snippet,) = (part.text for part in snippets(PAGES["guides/marl"]) if imported in part.text)
    # one thread: networks this small gain nothing from more, and other tests run beside
    quiet = {"OMP_NUM_THREADS": "1", "RAY_USAGE_STATS_ENABLED": "0"}
    printed = run([sys.executable, "-W", "ignore", "-c", snippet], tmp_path, packages(library), **quiet)
    steps, mean_return = printed.strip().splitlines()[-1].split()
    assert int(float(steps)) == 1200
    assert math.isfinite(float(mean_return))


def test_every_snippet_of_the_guide_belongs_to_one_library() -> None:
    found = [
        [name for name, (package, _) in LIBRARIES.items() if f"from {package}." in part.text] for part in snippets(PAGES["guides/marl"])
    ]
    assert found == [[name] for name in LIBRARIES]


@pytest.mark.parametrize(
    ("library", "name", "package"), [("benchmarl", "BenchMARL", "benchmarl"), ("benchmarl", "TorchRL", "torchrl"), ("rllib", "Ray", "ray"),
                                     ("rllib", "Gymnasium", "gymnasium")],
)  # fmt: skip
def test_the_guide_names_the_versions_that_it_is_tested_with(library: str, name: str, package: str) -> None:
    assert re.findall(rf"\| .*\b{name} ([\d.]+\d)", PAGES["guides/marl"].read_text(encoding="utf-8")) == [pinned(library)[package]]


@pytest.mark.parametrize("library", LIBRARIES)
def test_the_packages_are_those_that_the_library_asks_for(library: str) -> None:
    own = by_name(list(distributions(path=[str(packages(library))])))
    assert {name: each.version for name, each in own.items()} == pinned(library)
    everything = by_name(list(distributions())) | own
    package, extra = LIBRARIES[library]
    for name, each in own.items():
        for text in each.requires or ():
            asked = Requirement(text)
            if asked.marker is None or asked.marker.evaluate({"extra": extra if name == package else ""}):
                found = everything[canonicalize_name(asked.name)].version
                assert asked.specifier.contains(found, prereleases=True), f"{name} asks for {text}, found {found}"

"""The rooms of the repository build on one another in one order, the one that CONTRIBUTING.md draws."""

from __future__ import annotations

import re
from graphlib import CycleError, TopologicalSorter

import pytest

from tests.imports import PACKAGES, ROOT, imported, imports

ORDER = (
    ("swarm_envs.compiled", "swarm_envs.cores", "swarm_envs.deprecation"),
    ("swarm_envs.worlds",),
    ("swarm_envs.simulation", "hero_robot.firmware", "hardware"),
    ("swarm_envs.metrics", "hero_robot.fleet"),
    ("swarm_envs.behaviours", "swarm_envs.rendering"),
    ("swarm_envs.envs", "swarm_envs.calibration"),
    ("swarm_envs.policies",),
    ("swarm_envs",),
    ("discovery",),
    ("docs.studies",),
    ("docs.site",),
)
"""A room may import itself and what stands in the lines before it. ``swarm_envs`` alone is the package's front door."""
OLD_NAMES = ("discovery.deployment", "discovery.dataset", "discovery.run_folder", "discovery.representations.judged")
"""Rooms and modules that forward to others for one version; nothing imports them."""
WITHOUT = ("docs", "docs.conf", "hero_robot")
"""A package that says only what its folder is, and what Sphinx reads."""


def room_of(module: str) -> str:
    """The room that a module stands in: a package, or for the packages with rooms the part below it."""
    package, *rest = module.split(".")
    return f"{package}.{rest[0]}" if rest and package in ("swarm_envs", "hero_robot", "docs") else package


def rooms() -> dict[str, set[str]]:
    """By room, the other rooms that its modules import."""
    found: dict[str, set[str]] = {}
    for module, others in imports().items():
        if not module.startswith(OLD_NAMES) and module not in WITHOUT:
            ours = {room_of(other) for other in others if other.split(".")[0] in PACKAGES}
            found.setdefault(room_of(module), set()).update(ours - {room_of(module)})
    return found


def rank(room: str) -> int:
    return next(number for number, line in enumerate(ORDER) if room in line)


def test_every_room_stands_in_the_order() -> None:
    assert set(rooms()) == {room for line in ORDER for room in line}


def test_rooms_import_only_rooms_before_them() -> None:
    wrong = [f"{room} imports {other}" for room, others in rooms().items() for other in others if rank(other) >= rank(room)]
    assert not wrong


def test_no_module_imports_itself_through_others() -> None:
    try:
        TopologicalSorter({module: others & set(imports()) - {module} for module, others in imports().items()}).prepare()
    except CycleError as error:
        pytest.fail(" -> ".join(error.args[1]))


def test_the_robots_host_side_knows_the_world_file_and_nothing_else_of_the_project() -> None:
    assert rooms()["hero_robot.firmware"] == {"swarm_envs.worlds"}
    assert rooms()["hero_robot.fleet"] <= {"hero_robot.firmware", "swarm_envs.worlds", "swarm_envs.cores"}


def test_logs_that_test_calibration_share_no_code_with_what_they_test() -> None:
    generator = {module: others for module, others in imports().items() if module.startswith("docs.studies.calibration.generator")}
    assert len(generator) >= 10
    assert not {other for others in generator.values() for other in others if other.startswith(("swarm_envs", "discovery", "tests"))}


def test_nothing_that_is_installed_or_studied_imports_the_tests_or_an_old_name() -> None:
    wrong = [f"{module} imports {other}" for module, others in imports().items() for other in others
             if other.startswith(("tests", "hero_firmware", *OLD_NAMES)) and not module.startswith(OLD_NAMES)]  # fmt: skip
    assert not wrong


def test_what_is_installed_does_not_import_the_docs() -> None:
    assert not [
        module
        for module, others in imports().items()
        if not module.startswith("docs") and any(other.startswith("docs") for other in others)
    ]


def test_imports_inside_functions_and_of_modules_by_from_are_read() -> None:
    source = "import os.path\ndef f():\n    from discovery import settings, load_run\n    import swarm_envs.worlds as w\n"
    assert imported(source, {"discovery", "discovery.settings"}) == {"os.path", "discovery", "discovery.settings", "swarm_envs.worlds"}


def test_the_picture_in_contributing_is_the_order() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    picture = re.search(r"^```text\n(.*?)^```", text, flags=re.DOTALL | re.MULTILINE)
    assert picture is not None
    lines = [set(re.findall(r"[a-z_]+(?:\.[a-z_]+)*", line.split("  #")[0])) for line in picture[1].splitlines()]
    assert lines == [set(line) for line in ORDER]

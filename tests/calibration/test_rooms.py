"""The rooms of the calibration: imports run one way, between modules and between rooms."""

from __future__ import annotations

import ast
from graphlib import TopologicalSorter
from pathlib import Path

import swarm_envs.calibration

HOUSE = Path(swarm_envs.calibration.__file__).parent


def imports() -> dict[str, set[str]]:
    """By module, relative to the package, the modules of the package that it imports, anywhere in it."""
    package = "swarm_envs.calibration."
    paths = {str(path.relative_to(HOUSE).with_suffix("")).replace("/", "."): path for path in HOUSE.rglob("*.py")}
    found: dict[str, set[str]] = {}
    for module, path in paths.items():
        nodes = [node for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))) if isinstance(node, ast.ImportFrom)]
        names = {f"{node.module}.{name.name}" for node in nodes for name in node.names} | {str(node.module) for node in nodes}
        found[module] = {name.removeprefix(package) for name in names} & set(paths)
    return found


def test_no_module_imports_itself_through_others() -> None:
    found = imports()
    assert "logs.log" in found["drive.measured"]
    TopologicalSorter(found).prepare()


def test_no_room_imports_itself_through_others() -> None:
    def room(module: str) -> str:
        return module.partition(".")[0]

    rooms: dict[str, set[str]] = {}
    for module, others in imports().items():
        if not module.startswith("__"):
            rooms.setdefault(room(module), set()).update(room(other) for other in others if room(other) != room(module))
    assert "logs" in rooms["drive"]
    TopologicalSorter(rooms).prepare()

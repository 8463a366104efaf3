"""The rooms of discovery build on one another in one order."""

from __future__ import annotations

import ast
from pathlib import Path

import discovery

HOME = Path(discovery.__file__).parent
ORDER = (
    ("errors", "randomness", "progress", "controllers"),
    ("settings",),
    ("files",),
    ("tracking",),
    ("runs",),
    ("rollouts",),
    ("representations",),
    ("search",),
    ("clustering",),
    ("saved_run",),
    ("report",),
    ("export",),
    ("pipeline",),
    ("command",),
    ("annotation",),
    ("evaluation",),
)
"""What stands in a line may import what stands in the lines before it."""


def rank_of(room: str) -> int:
    return next(number for number, rooms in enumerate(ORDER) if room in rooms)


def imports_of(path: Path) -> set[str]:
    """Rooms of discovery that a file names in its imports, those inside functions included."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module is not None:
            modules = [node.module] if node.module != "discovery" else [f"discovery.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            modules = [alias.name for alias in node.names]
        else:
            continue
        found |= {module.split(".")[1] for module in modules if module.startswith("discovery.")}
    return found


def test_each_room_imports_only_itself_and_rooms_below_it() -> None:
    wrong = []
    for path in sorted(HOME.rglob("*.py")):
        room = path.relative_to(HOME).parts[0].removesuffix(".py")
        if room not in ("__init__", "__main__", "deployment"):
            others = imports_of(path) - {room, "deployment"}
            wrong += [f"{path.relative_to(HOME)} imports {other}" for other in others if rank_of(other) > rank_of(room)]
    assert not wrong


def test_every_module_stands_in_the_order() -> None:
    found = {path.name.removesuffix(".py") for path in HOME.iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()}
    assert found - {"__init__", "__main__", "deployment"} == {room for line in ORDER for room in line}

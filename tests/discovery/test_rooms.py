"""The rooms of discovery build on one another in one order."""

from __future__ import annotations

from pathlib import Path

import discovery
from tests.imports import imports

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
OLD_NAMES = {"deployment", "dataset", "run_folder"}
"""They forward for one version; nothing imports them."""


def rank_of(room: str) -> int:
    return next(number for number, rooms in enumerate(ORDER) if room in rooms)


def test_each_room_imports_only_itself_and_rooms_below_it() -> None:
    wrong = []
    for module, others in imports().items():
        package, _, rest = module.partition(".")
        room = rest.partition(".")[0]
        if package == "discovery" and room not in {"", "__main__", *OLD_NAMES}:
            theirs = {other.split(".")[1] for other in others if other.startswith("discovery.")} - {room, *OLD_NAMES}
            wrong += [f"{module} imports {other}" for other in theirs if rank_of(other) > rank_of(room)]
    assert not wrong


def test_every_module_stands_in_the_order() -> None:
    found = {path.name.removesuffix(".py") for path in HOME.iterdir() if path.suffix == ".py" or (path / "__init__.py").exists()}
    assert found - {"__init__", "__main__", *OLD_NAMES} == {room for line in ORDER for room in line}

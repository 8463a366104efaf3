"""The rooms of the calibration: imports run one way between them."""

from __future__ import annotations

from graphlib import TopologicalSorter

from tests.imports import imports

PACKAGE = "swarm_envs.calibration."


def room(module: str) -> str:
    return module.removeprefix(PACKAGE).partition(".")[0]


def test_no_room_imports_itself_through_others() -> None:
    rooms: dict[str, set[str]] = {}
    for module, others in imports().items():
        if module.startswith(PACKAGE):
            rooms.setdefault(room(module), set()).update(room(other) for other in others if other.startswith(PACKAGE))
    assert "logs" in rooms["drive"]
    TopologicalSorter({name: others - {name} for name, others in rooms.items()}).prepare()

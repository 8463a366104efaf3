"""From a :class:`WorldSpec` to the text of a world file, and back."""

from __future__ import annotations

import dataclasses
import itertools
import math
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from swarm_envs.worlds.load import load_world
from swarm_envs.worlds.quantity import Provenance
from swarm_envs.worlds.spec import RobotModel, WorldSpec


def world_to_text(world: WorldSpec) -> str:
    """Return a world as YAML that :func:`swarm_envs.load_world` reads back equal, units and sources included."""
    known = world.provenance
    document: dict[str, Any] = {"name": world.name, "description": world.description}
    groups = [(model, len(list(same))) for model, same in itertools.groupby(world.robots)]
    document["robots"] = [{"robot": _robot(model, known if len(groups) == 1 else {}), "count": count} for model, count in groups]
    document["tick"] = _leaf(world.tick, "s", known.get("tick"))
    for name in ("arena", "limits", "contact", "start"):
        document[name] = _section(getattr(world, name), name, known)
    document["arena"]["obstacles"] = [_section(item, f"arena.obstacles[{i}]", known) for i, item in enumerate(world.arena.obstacles)]
    document["objects"] = [_section(item, f"objects[{i}]", known) for i, item in enumerate(world.objects)]
    if world.broadcast is not None:
        document["broadcast"] = _section(world.broadcast, "broadcast", known)
    return yaml.safe_dump(document, sort_keys=False, allow_unicode=True, width=140)


def world_from_text(text: str) -> WorldSpec:
    """Return the world that :func:`world_to_text` wrote.

    Raises:
        WorldError: When the text is not a world.
    """
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "world.yaml"
        path.write_text(text, encoding="utf-8")
        return load_world(path)


def _robot(model: RobotModel, known: Mapping[str, Provenance]) -> dict[str, Any]:
    return {
        "name": model.name,
        "body": _section(model.body, "robot.body", known),
        "drive": _section(model.drive, "robot.drive", known),
        "sensors": [_section(item, f"robot.sensors[{i}]", known) for i, item in enumerate(model.sensors)],
        "effects": _section(model.effects, "robot.effects", known, skip_defaults=True),
    }


def _section(item: Any, key: str, known: Mapping[str, Provenance], *, skip_defaults: bool = False) -> dict[str, Any]:
    """The fields of a dataclass that a file gives as leaves."""
    section: dict[str, Any] = {}
    for field in dataclasses.fields(item):
        value = getattr(item, field.name)
        if dataclasses.is_dataclass(value) or (isinstance(value, tuple) and value and dataclasses.is_dataclass(value[0])):
            continue
        if field.name == "obstacles" or (skip_defaults and value == field.default):
            continue
        section[field.name] = _leaf(value, field.metadata["unit"], known.get(f"{key}.{field.name}")) if "unit" in field.metadata else value
    return section


def _leaf(value: Any, unit: str, provenance: Provenance | None) -> Any:
    leaf: dict[str, Any] = {"value": _plain(value), "unit": unit}
    if provenance is not None:
        leaf |= {name: text for name, text in (("source", provenance.source), ("note", provenance.note)) if text}
    return leaf


def _plain(value: Any) -> Any:
    if isinstance(value, tuple):
        return [_plain(item) for item in value]
    return value if not isinstance(value, float) or not math.isfinite(value) or value != int(value) or abs(value) > 1e6 else float(value)

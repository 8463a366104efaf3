"""From a name or a YAML file to a :class:`WorldSpec`, every mistake named with file, key and reason."""

from __future__ import annotations

import dataclasses
import difflib
import typing
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import yaml

from swarm_envs.worlds.effects import Effects
from swarm_envs.worlds.errors import WorldError
from swarm_envs.worlds.geometry import check_world_geometry
from swarm_envs.worlds.quantity import Provenance, as_numbers, is_leaf, read_leaf
from swarm_envs.worlds.spec import (
    Arena,
    Body,
    Broadcast,
    Contact,
    Drive,
    Limits,
    Obstacle,
    PushableObject,
    RobotModel,
    Sensor,
    Start,
    WorldSpec,
)

WORLDS = Path(__file__).parent
ROBOTS = WORLDS / "robots"

WORLD_KEYS = {
    "name", "description", "extends", "robot", "robots", "num_robots", "tick", "arena", "limits", "contact", "start",
    "objects", "broadcast", "effects",
}  # fmt: skip
ROBOT_KEYS = {"name", "description", "extends", "body", "drive", "sensors", "effects"}
HARDWARE_KEYS = {"parts", "electronics"}
"""Sections of a robot file that only firmware and CAD read."""


def world_names() -> list[str]:
    """Names of the worlds that come with the package.

    Example:
        >>> "hero_plus" in world_names()
        True
    """
    return sorted(path.stem for path in WORLDS.glob("*.yaml"))


def load_world(world: str | Path | WorldSpec, *, num_robots: int | None = None) -> WorldSpec:
    """Return the world with this name, from this file, or itself.

    Args:
        world: A shipped world's name, a path that ends in ``.yaml``, or a spec.
        num_robots: Take this many robots instead of the world's own number; models repeat in order.

    Raises:
        WorldError: When there is no such world, or the file is wrong; one line with file, key and reason.

    Example:
        >>> world = load_world("hero_plus", num_robots=3)
        >>> world.num_robots, world.size, world.limits.linear_speed
        (3, (1.7, 1.42), 0.09)
        >>> load_world("hero_pluss")
        Traceback (most recent call last):
        ...
        swarm_envs.worlds.errors.WorldError: unknown world 'hero_pluss'; did you mean 'hero_plus'?
    """
    if isinstance(world, WorldSpec):
        return _checked(world, num_robots)
    path = _find(str(world), WORLDS, "world")
    spec = _Reader(path).world()
    try:
        return _checked(spec, num_robots)
    except WorldError as error:  # a spec knows its name; the reader of the message needs the file
        raise WorldError(f"{path.name}: {str(error).removeprefix(f'{spec.name}: ')}") from None


def _checked(spec: WorldSpec, num_robots: int | None) -> WorldSpec:
    if num_robots is not None:
        spec = spec.with_robots(num_robots)
    check_world_geometry(spec)
    return spec


def load_robot_file(robot: str | Path) -> dict[str, Any]:
    """Return a robot file's values as plain nested dictionaries (units and sources stripped), ``extends`` resolved.

    Firmware and CAD read their constants with this, so that the simulated and the real robot share one file.

    Raises:
        WorldError: When there is no such robot, or the file is wrong.
    """
    path = _find(str(robot), ROBOTS, "robot")
    _Reader(path).robot_model()  # refuses a wrong file before anyone builds from it
    return typing.cast(dict[str, Any], _strip(_read_yaml(path)))


def _strip(node: Any) -> Any:
    if is_leaf(node):
        return node["value"]
    if isinstance(node, Mapping):
        return {key: _strip(value) for key, value in node.items()}
    if isinstance(node, list):
        return [_strip(item) for item in node]
    return node


def _find(name: str, folder: Path, kind: str) -> Path:
    if name.endswith((".yaml", ".yml")):
        path = Path(name).expanduser()
        if not path.is_file():
            raise WorldError(f"{name}: no such {kind} file; give an existing .yaml file or one of {_shipped(folder)}")
        return path
    path = folder / f"{name}.yaml"
    if "/" in name or not path.is_file():
        known = [p.stem for p in folder.glob("*.yaml")]
        close = difflib.get_close_matches(name, known, 1)
        hint = f"did you mean {close[0]!r}?" if close else f"give one of {_shipped(folder)}, or a path that ends in .yaml"
        raise WorldError(f"unknown {kind} {name!r}; {hint}")
    return path


def _shipped(folder: Path) -> str:
    return ", ".join(sorted(p.stem for p in folder.glob("*.yaml")))


def _read_yaml(path: Path, seen: tuple[Path, ...] = ()) -> dict[str, Any]:
    """Parse a file and merge it over the file that it extends."""
    path = path.resolve()
    if path in seen:
        raise WorldError(f"{path.name}: 'extends' leads back to itself; remove the circle")
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except yaml.YAMLError as error:
        reason = " ".join(str(error).split())
        raise WorldError(f"{path}: not valid YAML ({reason})") from None
    except (OSError, UnicodeDecodeError) as error:
        raise WorldError(f"{path}: cannot be read ({error}); give a readable YAML file") from None
    if not isinstance(document, dict):
        raise WorldError(f"{path}: expected a mapping of keys at the top, given {type(document).__name__}")
    base = document.pop("extends", None)
    if base is None:
        return document
    sibling = path.parent / f"{base}.yaml"
    folder = ROBOTS if path.parent == ROBOTS else WORLDS
    try:
        base_path = sibling if sibling.is_file() else _find(str(base), folder, "base")
    except WorldError as error:
        raise WorldError(f"{path.name}: extends: {error}") from None
    merged: dict[str, Any] = _merge(_read_yaml(base_path, (*seen, path)), document)
    return merged


def _merge(base: Any, over: Any) -> Any:
    """Lay ``over`` on ``base``, mapping by mapping; a sourced number is replaced whole."""
    if isinstance(base, Mapping) and isinstance(over, Mapping) and not is_leaf(base) and not is_leaf(over):
        return {**base, **{key: _merge(base[key], value) if key in base else value for key, value in over.items()}}
    return over


class _Reader:
    """Reads one file into dataclasses, remembering where every number came from."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.document = _read_yaml(path)
        self.provenance: dict[str, Provenance] = {}

    def fail(self, key: str, reason: str) -> typing.NoReturn:
        raise WorldError(f"{self.path.name}: {key}: {reason}")

    def check_keys(self, node: Any, allowed: Iterable[str], key: str) -> Mapping[str, Any]:
        if not isinstance(node, Mapping):
            self.fail(key or "top", f"given {node!r}, expected a mapping of keys")
        allowed = sorted(allowed)
        for name in node:
            if name not in allowed:
                close = difflib.get_close_matches(str(name), allowed, 1)
                hint = f"did you mean {close[0]!r}?" if close else f"expected only {', '.join(allowed)}"
                self.fail(f"{key}.{name}" if key else str(name), f"unknown key; {hint}")
        return node

    def section(self, cls: type, node: Any, key: str, base: Any = None) -> Any:
        """Build the dataclass ``cls`` from a mapping; fields absent from it come from ``base`` or the defaults."""
        fields = {f.name: f for f in dataclasses.fields(cls)}
        items = self.check_keys(node, fields, key)
        values: dict[str, Any] = {} if base is None else {name: getattr(base, name) for name in fields}
        types_by_name = typing.get_type_hints(cls)
        for name, item in items.items():
            values[name] = self.leaf(item, f"{key}.{name}", fields[name], types_by_name[name])
        for name, f in fields.items():
            if name not in values and f.default is dataclasses.MISSING and f.default_factory is dataclasses.MISSING:
                self.fail(f"{key}.{name}", "missing; every " + cls.__name__.lower() + " needs it")
        return cls(**values)

    def leaf(self, item: Any, key: str, f: dataclasses.Field[Any], kind: Any) -> Any:
        where = f"{self.path.name}: {key}"
        if "unit" not in f.metadata:
            wanted = bool if kind is bool else str
            if not isinstance(item, wanted):
                self.fail(key, f"given {item!r}, expected {'true or false' if wanted is bool else 'a text'}")
            return item
        value, provenance = read_leaf(item, where, f.metadata["unit"])
        if provenance is not None:
            self.provenance[key] = provenance
        numbers = as_numbers(value, where, f.metadata["low"], f.metadata["high"])
        if (kind is float) != isinstance(numbers, float):
            self.fail(key, f"given {value!r}, expected {'one number' if kind is float else 'a list of numbers'}")
        return numbers

    def robot_model(self, overrides: Mapping[str, Any] | None = None) -> RobotModel:
        node: dict[str, Any] = _merge(self.document, overrides or {})
        self.check_keys(node, ROBOT_KEYS | HARDWARE_KEYS, "")
        for needed in ("body", "drive", "sensors"):
            if needed not in node:
                self.fail(needed, "missing; every robot file needs body, drive and sensors")
        return self.build_model(node, str(node.get("name", self.path.stem)), "")

    def robots(self) -> tuple[RobotModel, ...]:
        """The world's robots in order, from ``robot`` (one model) or ``robots`` (a list of models with counts)."""
        node = self.document
        if ("robot" in node) == ("robots" in node):
            self.fail("robot", "give either 'robot' (one model for all) or 'robots' (a list of {robot, count})")
        common = self.section(Effects, node.get("effects", {}), "effects")
        shared = set(node.get("effects", {}))
        if "robot" in node:
            groups: list[Any] = [{"robot": node["robot"], "count": self.count(node.get("num_robots", 1), "num_robots")}]
        else:
            if "num_robots" in node:
                self.fail("num_robots", "not allowed beside 'robots'; write a count in each group")
            if not isinstance(node["robots"], list) or not node["robots"]:
                self.fail("robots", f"given {node['robots']!r}, expected a list of {{robot, count}}")
            groups = node["robots"]
        robots: list[RobotModel] = []
        for index, group in enumerate(groups):
            key = f"robots[{index}]"
            group = self.check_keys(group, {"robot", "count"}, key)
            model = self.model(group.get("robot"), key)
            changed = {name: getattr(common, name) for name in shared}
            model = dataclasses.replace(model, effects=dataclasses.replace(model.effects, **changed))
            robots += [model] * self.count(group.get("count", 1), f"{key}.count")
        return tuple(robots)

    def model(self, node: Any, key: str) -> RobotModel:
        """A robot model from its name or path, or from a mapping ``{extends: name, ...changes}``."""
        overrides: Mapping[str, Any] = {}
        if isinstance(node, Mapping) and "extends" not in node:
            return self.inline_model(node, key)
        if isinstance(node, Mapping):
            overrides = {name: value for name, value in node.items() if name != "extends"}
            node = node.get("extends")
        if not isinstance(node, str):
            self.fail(key, f"robot is {node!r}, expected a name, a .yaml path, or {{extends: name, ...}}")
        sibling = self.path.parent / node
        try:
            path = sibling if node.endswith(".yaml") and sibling.is_file() else _find(node, ROBOTS, "robot")
        except WorldError as error:
            self.fail(key, str(error))
        try:
            reader = _Reader(path)
            model = reader.robot_model(overrides)
        except WorldError as error:
            self.fail(f"{key}.robot", str(error))
        self.provenance |= {f"robot.{name}": p for name, p in reader.provenance.items()}
        return model

    def inline_model(self, node: Mapping[str, Any], key: str) -> RobotModel:
        """A robot model written out in the world file."""
        self.check_keys(node, ROBOT_KEYS, key)
        for needed in ("body", "drive", "sensors"):
            if needed not in node:
                self.fail(f"{key}.{needed}", "missing; a robot written out needs body, drive and sensors (or give extends: name)")
        return self.build_model(node, str(node.get("name", "robot")), "robot.")

    def build_model(self, node: Mapping[str, Any], name: str, prefix: str) -> RobotModel:
        if not isinstance(node["sensors"], list) or not node["sensors"]:
            self.fail(f"{prefix}sensors", f"given {node['sensors']!r}, expected a list of at least one sensor")
        return RobotModel(
            name=name,
            body=self.section(Body, node["body"], f"{prefix}body"),
            drive=self.section(Drive, node["drive"], f"{prefix}drive"),
            sensors=tuple(self.section(Sensor, item, f"{prefix}sensors[{i}]") for i, item in enumerate(node["sensors"])),
            effects=self.section(Effects, node.get("effects", {}), f"{prefix}effects"),
        )

    def count(self, item: Any, key: str) -> int:
        value, provenance = read_leaf(item, f"{self.path.name}: {key}", "1")
        if provenance is not None:
            self.provenance[key] = provenance
        if isinstance(value, bool) or not isinstance(value, int) or not 1 <= value <= 1000:
            self.fail(key, f"given {value!r}, expected a whole number from 1 to 1000")
        return value

    def arena(self, given: Any) -> Arena:
        node = dict(self.check_keys(given, {f.name for f in dataclasses.fields(Arena)}, "arena"))
        obstacles = node.pop("obstacles", [])
        if not isinstance(obstacles, list):
            self.fail("arena.obstacles", f"given {obstacles!r}, expected a list")
        arena: Arena = self.section(Arena, node, "arena")
        built = tuple(self.section(Obstacle, item, f"arena.obstacles[{i}]") for i, item in enumerate(obstacles))
        return dataclasses.replace(arena, obstacles=built)

    def world(self) -> WorldSpec:
        node = self.check_keys(self.document, WORLD_KEYS, "")
        for needed in ("arena", "limits"):
            if needed not in node:
                self.fail(needed, "missing; every world needs it")
        tick_field = next(f for f in dataclasses.fields(WorldSpec) if f.name == "tick")
        objects = node.get("objects", [])
        if not isinstance(objects, list):
            self.fail("objects", f"given {objects!r}, expected a list")
        return WorldSpec(
            name=str(node.get("name", self.path.stem)),
            description=str(node.get("description", "")),
            robots=self.robots(),
            arena=self.arena(node["arena"]),
            limits=self.section(Limits, node["limits"], "limits"),
            contact=self.section(Contact, node.get("contact", {}), "contact"),
            start=self.section(Start, node.get("start", {}), "start"),
            objects=tuple(self.section(PushableObject, item, f"objects[{i}]") for i, item in enumerate(objects)),
            broadcast=self.section(Broadcast, node["broadcast"], "broadcast") if "broadcast" in node else None,
            tick=self.leaf(node["tick"], "tick", tick_field, float) if "tick" in node else 0.1,
            provenance=self.provenance,
        )

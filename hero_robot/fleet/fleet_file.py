"""The fleet file: which robots there are, where they listen, and their keys."""

from __future__ import annotations

import os
import secrets
import stat
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from hero_robot.fleet.errors import FleetError
from swarm_envs.worlds import load_robot_file

KEY_SIZE = 32
"""Bytes of a robot's key."""


@dataclass(frozen=True)
class RobotEntry:
    """One robot of a fleet."""

    name: str
    number: int
    host: str
    port: int
    key: bytes


@dataclass(frozen=True)
class Fleet:
    """The robots of a lab and how their server behaves."""

    name: str
    robots: tuple[RobotEntry, ...]
    page_port: int = 8080
    """TCP port of the live page on this machine."""
    lease: float = 0.35
    """Motion granted by a heartbeat, s, counted from when it is sent; robots take 0.5 at most."""
    heartbeat: float = 0.035
    """Time between heartbeats, s: ten may be lost in a row before a robot stops."""


def link_constants() -> dict[str, Any]:
    """The link's numbers, from the robot file that the firmware's come from."""
    link: dict[str, Any] = load_robot_file("hero_plus")["electronics"]["link"]
    return link


def read_fleet(path: Path) -> Fleet:
    """Read a fleet file.

    Raises:
        FleetError: When it is absent, readable by others (it holds keys), or wrong; one line with file, key and reason.
    """
    try:
        mode = path.stat().st_mode
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise FleetError(f"{path}: cannot be read ({error.strerror}); write one with: python -m hero_robot.fleet keys 8 {path}") from None
    except yaml.YAMLError as error:
        raise FleetError(f"{path}: not valid YAML ({' '.join(str(error).split())})") from None
    if os.name == "posix" and mode & (stat.S_IRWXG | stat.S_IRWXO):
        raise FleetError(f"{path}: holds keys and others may read it (mode {stat.S_IMODE(mode):o}); chmod 600 {path}")
    return _fleet(document, path)


def _fleet(document: Any, path: Path) -> Fleet:
    allowed = {"name", "robots", "page_port", "lease", "heartbeat"}
    if not isinstance(document, dict) or not isinstance(document.get("robots"), list) or not document["robots"]:
        raise FleetError(f"{path}: expected 'robots', a list of {{name, number, host, port, key}}")
    unknown = set(document) - allowed
    if unknown:
        raise FleetError(f"{path}: unknown key {sorted(unknown)[0]!r}; expected only {', '.join(sorted(allowed))}")
    robots = tuple(_robot(node, f"{path}: robots[{index}]") for index, node in enumerate(document["robots"]))
    for kind in ("name", "number"):
        values = [getattr(robot, kind) for robot in robots]
        if len(set(values)) < len(values):
            raise FleetError(f"{path}: two robots have the same {kind}; each needs its own")
    fleet = Fleet(
        name=str(document.get("name", path.stem)),
        robots=robots,
        page_port=int(document.get("page_port", 8080)),
        lease=float(document.get("lease", 0.35)),
        heartbeat=float(document.get("heartbeat", 0.035)),
    )
    most = link_constants()["lease_max"]
    if not 0.01 <= fleet.heartbeat < fleet.lease <= most:
        raise FleetError(f"{path}: heartbeat {fleet.heartbeat} s and lease {fleet.lease} s; expected 0.01 <= heartbeat < lease <= {most}")
    return fleet


def _robot(node: Any, where: str) -> RobotEntry:
    wanted = {"name": str, "number": int, "host": str, "port": int, "key": str}
    if not isinstance(node, dict) or set(node) != set(wanted):
        raise FleetError(f"{where}: expected exactly the keys {', '.join(wanted)}")
    for key, kind in wanted.items():
        if not isinstance(node[key], kind) or isinstance(node[key], bool):
            raise FleetError(f"{where}.{key}: given a {type(node[key]).__name__}, expected a {kind.__name__}")
    if not (1 <= node["number"] <= 65535 and 1 <= node["port"] <= 65535):
        raise FleetError(f"{where}: number {node['number']} and port {node['port']} must lie between 1 and 65535")
    try:
        secret = bytes.fromhex(node["key"])
    except ValueError:
        secret = b""
    if len(secret) != KEY_SIZE or len(set(secret)) < 4:
        raise FleetError(
            f"{where}.key: expected {2 * KEY_SIZE} random hexadecimal digits; write new ones with: python -m hero_robot.fleet keys"
        )
    return RobotEntry(node["name"], node["number"], node["host"], node["port"], secret)


def write_new_fleet(path: Path, hosts: list[str], ports: list[int], page_port: int = 8080) -> None:
    """Write a fleet file with fresh keys, readable by its owner alone.

    Raises:
        FleetError: When the file is there already: its keys may be in use.
    """
    robots = [
        {"name": f"hero_{i + 1}", "number": i + 1, "host": host, "port": port, "key": secrets.token_hex(KEY_SIZE)}
        for i, (host, port) in enumerate(zip(hosts, ports, strict=True))
    ]
    document = {"name": path.stem, "page_port": page_port, "lease": 0.35, "heartbeat": 0.035, "robots": robots}
    try:
        handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    except FileExistsError:
        raise FleetError(f"{path}: exists, and its keys may be in use; give another name or remove it first") from None
    with os.fdopen(handle, "w", encoding="utf-8") as stream:
        yaml.safe_dump(document, stream, sort_keys=False)


def secrets_header(robot: RobotEntry, wifi_name: str, wifi_password: str) -> str:
    """The text of ``secrets.h`` for this robot's board."""
    return "\n".join(
        [
            "#ifndef HERO_SECRETS_H",
            "#define HERO_SECRETS_H",
            f"#define HERO_WIFI_NAME {_c_string(wifi_name)}",
            f"#define HERO_WIFI_PASSWORD {_c_string(wifi_password)}",
            f"#define HERO_ROBOT {robot.number}",
            f'#define HERO_KEY "{robot.key.hex()}"',
            "#define HERO_HALT_LEFT_US 0",
            "#define HERO_HALT_RIGHT_US 0",
            "#endif",
            "",
        ]
    )


def _c_string(text: str) -> str:
    return '"' + "".join(f"\\{byte:03o}" if byte < 32 or byte > 126 or byte in b'"\\?' else chr(byte) for byte in text.encode()) + '"'

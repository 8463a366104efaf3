"""Logs from ROS 1 and ROS 2 bags, through the ``rosbags`` package: each bag is a run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from swarm_envs.calibration.errors import LogError
from swarm_envs.calibration.logs.log import Log
from swarm_envs.calibration.logs.messages import read_command, read_detection, read_poses
from swarm_envs.calibration.logs.tables import COLUMNS, Rows, as_log, clean, command_scales, refuse_missing
from swarm_envs.calibration.logs.topics import TF_TYPES, Source, TopicMap, guess_topics, read_topic_map

SUFFIXES = (".bag", ".mcap", ".db3")
LOOK = 500
"""Messages of a tf topic in which frames are looked for when topics are guessed."""


def bags_in(path: Path) -> list[Path]:
    """Return the bags that a path names: a file, a ROS 2 bag's folder, or all bags in a folder; none for anything else."""
    if path.is_file():
        # a ROS 2 bag is its folder; its files are parts of it
        folder = path.parent
        return [folder if path.suffix == ".db3" and (folder / "metadata.yaml").is_file() else path] if path.suffix in SUFFIXES else []
    if (path / "metadata.yaml").is_file():
        return [path]
    if not path.is_dir():
        return []
    return sorted(p for p in path.iterdir() if p.suffix in (".bag", ".mcap") or (p / "metadata.yaml").is_file())


def read_bags(bags: Sequence[Path], topics: str | Path | TopicMap | None = None) -> Log:
    """Return the log in some bags, each of them a run named after its file.

    Args:
        bags: ROS 1 bags, or folders (or ``.mcap`` files) of ROS 2 bags.
        topics: A topic map or its file; without it topics are guessed by name and type, and the log's notes say how.

    Raises:
        LogError: When a bag or the map cannot be read, or topics cannot be guessed.
    """
    given = topics if isinstance(topics, TopicMap) or topics is None else read_topic_map(topics)
    tables: dict[str, dict[tuple[str, str], Rows]] = {name: {} for name in COLUMNS}
    notes: list[str] = []
    chosen = given
    names = _names(bags)
    for bag in bags:
        chosen = given or _guess(bag)
        notes += [note for note in chosen.notes if note not in notes]
        scales = command_scales(chosen.about.get("units", {}), bag)[0]
        found = _rows(bag, chosen)
        for kind, robot in ((kind, robot) for robot in chosen.robots for kind in COLUMNS if (kind, robot) in found):
            rows = found[kind, robot]
            numbers = np.array(rows, float).reshape(-1, 1 + len(COLUMNS[kind]))
            numbers *= [scales.get(column, 1.0) if column != "t" else 1.0 for column in ("t", *COLUMNS[kind])]
            source = chosen.robots[robot][kind]
            refuse_missing(f"{bag}: {source.topic}: message", kind, numbers, ("t", *COLUMNS[kind]), first=1)
            tables[kind][names[bag], robot] = clean(kind, f"{names[bag]}, {source.topic}", numbers, notes)
    assert chosen is not None
    if given is not None:
        _refuse_silent(given, tables, bags)
    default = bags[0].stem if len(bags) == 1 else bags[0].parent.name
    return as_log({"name": default, **chosen.about}, tables, Path(bags[0]), notes)


def _names(bags: Sequence[Path]) -> dict[Path, str]:
    """Name each run after its bag, with the folder's where two bags share a name."""
    stems = [bag.stem for bag in bags]
    return {bag: bag.stem if stems.count(bag.stem) == 1 else f"{bag.parent.name}/{bag.stem}" for bag in bags}


def _open(bag: Path) -> Any:
    try:
        from rosbags.highlevel import AnyReader, AnyReaderError
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        raise LogError(f"{bag}: reading bags needs rosbags; install swarm-envs[calibration]") from None
    try:
        # a bag's own definitions come first; older ROS 2 bags have none
        reader = AnyReader([bag], default_typestore=get_typestore(Stores.LATEST))
        reader.open()
    except (AnyReaderError, OSError, ValueError) as error:
        raise LogError(f"{bag}: cannot be read as a ROS bag ({' '.join(str(error).split())}); give a finished, undamaged bag") from None
    return reader


def _guess(bag: Path) -> TopicMap:
    reader = _open(bag)
    try:
        connections = [connection for connection in reader.connections if connection.msgcount]
        transforms = [connection for connection in connections if connection.msgtype in TF_TYPES]
        frames = set()
        for count, (topic, _, message) in enumerate(_messages(reader, transforms, bag)):
            if count > LOOK:
                break
            frames |= {(topic, t.header.frame_id.strip("/"), t.child_frame_id.strip("/")) for t in message.transforms}
        try:
            return guess_topics({connection.topic: connection.msgtype for connection in connections}, frozenset(frames))
        except LogError as error:
            raise LogError(f"{bag}: {error}") from None
    finally:
        reader.close()


def _rows(bag: Path, topics: TopicMap) -> dict[tuple[str, str], list[tuple[float, ...]]]:
    """Return rows (t, ...) by table and robot; times from the first of all messages of the robots, in s."""
    wanted: dict[str, list[tuple[str, str, Source]]] = {}
    for robot, sources in topics.robots.items():
        for kind, source in sources.items():
            wanted.setdefault(source.topic, []).append((kind, robot, source))
    rows: dict[tuple[str, str], list[tuple[float, ...]]] = {}
    reader = _open(bag)
    try:
        connections = [connection for connection in reader.connections if connection.topic in wanted]
        for topic, received, message in _messages(reader, connections, bag):
            for kind, robot, source in wanted[topic]:
                if kind == "poses":
                    found = list(read_poses(message, source))
                else:
                    found = [read_command(message, source) if kind == "commands" else read_detection(message, source)]
                for stamp, numbers in found:
                    if source.time == "stamp" and stamp is None:
                        raise LogError(f"{bag}: {topic}: messages have no header; write time: receipt in the topic map")
                    time = received if source.time == "receipt" or stamp is None else stamp
                    rows.setdefault((kind, robot), []).append((time, *numbers))
    finally:
        reader.close()
    begin = min((row[0] for part in rows.values() for row in part), default=0.0)
    return {key: [(row[0] - begin, *row[1:]) for row in part] for key, part in rows.items()}


def _messages(reader: Any, connections: list[Any], bag: Path) -> Iterator[tuple[str, float, Any]]:
    """Yield topic, time of receipt in s, and message."""
    if not connections:
        return
    try:
        for connection, received, raw in reader.messages(connections=connections):
            yield connection.topic, 1e-9 * received, reader.deserialize(raw, connection.msgtype)
    except LogError:
        raise
    except Exception as error:  # a damaged bag fails in many ways
        raise LogError(f"{bag}: damaged ({type(error).__name__}: {' '.join(str(error).split())}); give an undamaged bag") from None


def _refuse_silent(topics: TopicMap, tables: dict[str, dict[tuple[str, str], Rows]], bags: Sequence[Path]) -> None:
    """Refuse a map with a topic that no bag has a message of."""
    for robot, sources in topics.robots.items():
        for kind, source in sources.items():
            if not any(name == robot for _, name in tables[kind]):
                reader = _open(bags[0])
                listed = ", ".join(sorted({f"{c.topic} ({c.msgtype})" for c in reader.connections}))
                reader.close()
                what = f"{source.topic}, child {source.child!r}" if source.child else source.topic
                raise LogError(f"{bags[0]}: no message on {what}, which the topic map gives as {kind} of {robot}. Topics: {listed}")

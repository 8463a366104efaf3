"""A measured log: what was commanded, where the robots went, what they reported to see.

A log is a folder with ``log.yaml`` (robot, units, source, optionally the arena's ``outline`` in the log's own frame) and the tables
``poses`` (run, robot, t, x, y, theta), ``commands`` (run, robot, t, v, omega; in force from t until the next row) and, if any,
``detections`` (run, robot, t, detected), as CSV or Parquet; ROS bags are logs too, see :mod:`swarm_envs.calibration.bags`. Times are
seconds from the start of a run, one clock.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import numpy.typing as npt
import yaml

from swarm_envs.calibration.errors import LogError

if TYPE_CHECKING:
    from swarm_envs.calibration.topics import TopicMap

FloatArray = npt.NDArray[np.float64]
BoolArray = npt.NDArray[np.bool_]

COLUMNS = {"poses": ("x", "y", "theta"), "commands": ("v", "omega"), "detections": ("detected",)}
SCALES = {
    "t": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "x": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "y": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "theta": {"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180, "degrees": math.pi / 180},
    "v": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3},
    "omega": {"rad/s": 1.0, "deg/s": math.pi / 180, "mrad/s": 1e-3},
}
"""Units that a log may declare, and what they are in SI. Commands may also be in the driver's own units: gains are then fitted."""
FASTEST = 5.0
"""A robot faster than this, m/s, is a tracker that jumped."""


@dataclass(frozen=True)
class Track:
    """One robot in one run, in SI units, each table sorted by time without duplicates."""

    run: str
    """Name of the run."""
    robot: str
    """Name of the robot."""
    times: FloatArray
    """(T,) of the poses, s from the start of the run."""
    poses: FloatArray
    """(T, 3) x and y in m, heading in rad, unwrapped."""
    command_times: FloatArray
    """(M,) s."""
    commands: FloatArray
    """(M, 2) v and omega, in force until the next; in m/s and rad/s, or the driver's units."""
    detection_times: FloatArray
    """(D,) s."""
    detections: BoolArray
    """(D,) whether the robot's sensor reported another."""

    @property
    def duration(self) -> float:
        """Time from the first to the last pose in s."""
        return float(self.times[-1] - self.times[0]) if len(self.times) else 0.0


@dataclass(frozen=True)
class Log:
    """A measured log."""

    name: str
    """Name that the log gives itself, else its folder's."""
    tracks: tuple[Track, ...]
    """Every robot of every run, in the order of their first appearance."""
    outline: tuple[tuple[float, float], ...] | None = None
    """Corners of the arena in the log's own frame in m, if the log gives them."""
    driver_units: bool = False
    """Whether the log does not say that its commands are in SI units."""
    notes: tuple[str, ...] = ()
    """What was repaired on reading, a sentence each."""

    @property
    def runs(self) -> tuple[str, ...]:
        """Names of the runs, in order."""
        return tuple(dict.fromkeys(track.run for track in self.tracks))

    @property
    def robots(self) -> tuple[str, ...]:
        """Names of the robots, in order."""
        return tuple(dict.fromkeys(track.robot for track in self.tracks))

    @property
    def tracked(self) -> tuple[Track, ...]:
        """Tracks with poses and commands enough to predict anything."""
        return tuple(track for track in self.tracks if len(track.times) > 10 and len(track.command_times))


def read_log(*sources: str | Path, topics: str | Path | TopicMap | None = None) -> Log:
    """Return the log in a folder or in ROS bags.

    Args:
        sources: A folder with ``log.yaml`` and the tables; or ROS 1 or ROS 2 bags, or folders of them, each bag a run.
        topics: For bags: which topics are what, a map or its YAML file; guessed by name and type where absent.

    Raises:
        LogError: When something cannot be used; one line with file, row and reason.
    """
    from swarm_envs.calibration.bags import bags_in, read_bags

    folders = [Path(source) for source in sources]
    for folder in folders:
        if not folder.exists():
            raise LogError(f"{folder}: no such folder; give a log folder with log.yaml, poses and commands, or a ROS bag")
    bags = [bag for folder in folders if not (folder / "log.yaml").is_file() for bag in bags_in(folder)]
    if not bags:
        if len(folders) != 1:
            raise LogError(f"given {len(folders)} sources without a ROS bag among them, expected one log folder, or bags")
        if topics is not None:
            raise LogError(f"{folders[0]}: a topic map is given, but no ROS bag; leave --topics out for a log folder")
        return _read_folder(folders[0])
    others = [folder for folder in folders if (folder / "log.yaml").is_file() or not bags_in(folder)]
    if others:
        raise LogError(f"{others[0]}: not a ROS bag, given among bags; give bags alone, or one log folder")
    return read_bags(bags, topics)


def _read_folder(folder: Path) -> Log:
    description = _description(folder / "log.yaml")
    scales, _ = command_scales(description.get("units", {}), folder / "log.yaml")
    notes: list[str] = []
    tables = {name: _table(folder, name, scales, notes) for name in COLUMNS}
    if not tables["commands"]:
        raise LogError(f"{folder}/commands: no rows; a log needs the commands that the robots were given")
    return as_log({"name": folder.name, **description}, tables, folder / "log.yaml", notes)


class Rows(NamedTuple):
    """A table's rows of one robot in one run."""

    times: FloatArray
    """(N,) s."""
    values: FloatArray
    """(N, columns) in SI units."""


Table = dict[tuple[str, str], Rows]
"""Rows by run and robot."""


def as_log(about: Mapping[str, Any], tables: Mapping[str, Table], where: Path, notes: Sequence[str]) -> Log:
    """Return the log with these tables.

    Args:
        about: ``name``, ``units`` and ``outline``, as in ``log.yaml``.
        tables: By name, see :data:`COLUMNS`; cleaned.
        where: File that a mistake in ``about`` is in.
        notes: What was repaired.
    """
    keys = list(dict.fromkeys(key for table in tables.values() for key in table))
    return Log(
        name=str(about["name"]), tracks=tuple(_track(key, tables) for key in keys), outline=_outline(_given_outline(about), where),
        driver_units=command_scales(about.get("units", {}), where)[1], notes=tuple(notes),
    )  # fmt: skip


def _description(path: Path) -> dict[str, Any]:
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as error:
        raise LogError(f"{path}: cannot be read ({error}); a log folder says there what it is") from None
    except yaml.YAMLError as error:
        raise LogError(f"{path}: not valid YAML ({' '.join(str(error).split())})") from None
    if not isinstance(document, dict):
        raise LogError(f"{path}: expected a mapping of keys, given {type(document).__name__}")
    return document


def command_scales(units: Any, path: Path) -> tuple[dict[str, float], bool]:
    """Return the factor to SI of every column, and whether commands are in units of the driver's own.

    Raises:
        LogError: When a unit of the poses is not known.
    """
    if not isinstance(units, dict):
        raise LogError(f"{path}: units is {units!r}, expected a mapping from column to unit")
    scales, driver = {}, False
    for column, known in SCALES.items():
        text = str(units.get(column, next(iter(known)))).strip()
        word = text.split()[0].rstrip(",;") if text else ""
        if word in known:
            scales[column] = known[word]
        elif column in ("v", "omega"):
            scales[column], driver = 1.0, True
        else:
            raise LogError(f"{path}: units.{column} is {text!r}, expected one of {', '.join(known)}")
    return scales, driver


def _given_outline(description: Mapping[str, Any]) -> Any:
    """The outline at the top of the file or, as in a world file, under ``arena``."""
    arena = description.get("arena")
    return description.get("outline", arena.get("outline") if isinstance(arena, dict) else None)


def _outline(given: Any, path: Path) -> tuple[tuple[float, float], ...] | None:
    if given is None:
        return None
    try:
        corners = tuple((float(x), float(y)) for x, y in given)
    except (TypeError, ValueError):
        raise LogError(f"{path}: outline is {given!r}, expected a list of corners [x, y] in m") from None
    if len(corners) < 3 or not np.isfinite(corners).all():
        raise LogError(f"{path}: outline has {len(corners)} corners, expected at least 3, all finite")
    return corners


def _table(folder: Path, name: str, scales: dict[str, float], notes: list[str]) -> Table:
    """Rows of one table by (run, robot), sorted by time, duplicates dropped, in SI units."""
    path = next((p for p in (folder / f"{name}.csv", folder / f"{name}.parquet") if p.is_file()), None)
    if path is None:
        if name == "commands":
            raise LogError(f"{folder}: neither {name}.csv nor {name}.parquet; a log needs the commands that the robots were given")
        return {}
    columns = COLUMNS[name]
    cells = _csv_cells(path, columns) if path.suffix == ".csv" else _parquet_cells(path, columns)
    groups: dict[tuple[str, str], list[int]] = {}
    for index, key in enumerate(zip(cells["run"], cells["robot"], strict=True)):
        groups.setdefault((str(key[0]), str(key[1])), []).append(index)
    numbers = np.stack([_numbers(path, column, cells[column]) for column in ("t", *columns)], axis=1) if groups else np.empty((0, 0))
    for column, factor in zip(("t", *columns), (scales.get(c, 1.0) for c in ("t", *columns)), strict=True):
        if len(numbers):
            numbers[:, ("t", *columns).index(column)] *= factor
    refuse_missing(f"{path}: row", name, numbers, ("t", *columns), first=2)
    return {key: clean(name, f"{path.name}, {key[0]}, {key[1]}", numbers[rows], notes) for key, rows in groups.items()}


def _csv_cells(path: Path, columns: tuple[str, ...]) -> dict[str, list[Any]]:
    try:
        with path.open(encoding="utf-8-sig", newline="") as stream:
            rows = list(csv.reader(stream))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise LogError(f"{path}: cannot be read as CSV ({error})") from None
    head = [cell.strip() for cell in rows[0]] if rows else []
    _require_columns(path, head, columns)
    body = [(number, row) for number, row in enumerate(rows[1:], start=2) if row]
    for number, row in body:
        if len(row) != len(head):
            raise LogError(f"{path}: row {number}: {len(row)} cells, expected {len(head)} ({', '.join(head)})")
    return {column: [row[head.index(column)] for _, row in body] for column in ("run", "robot", "t", *columns)}


def _parquet_cells(path: Path, columns: tuple[str, ...]) -> dict[str, list[Any]]:
    try:
        from pyarrow import parquet
    except ImportError:
        raise LogError(f"{path}: reading Parquet needs pyarrow; install swarm-envs[calibration] or give a CSV file") from None
    try:
        table = parquet.read_table(path)
    except Exception as error:  # pyarrow raises many kinds
        raise LogError(f"{path}: cannot be read as Parquet ({' '.join(str(error).split())})") from None
    _require_columns(path, table.column_names, columns)
    return {column: table.column(column).to_pylist() for column in ("run", "robot", "t", *columns)}


def _require_columns(path: Path, head: list[str], columns: tuple[str, ...]) -> None:
    missing = [column for column in ("run", "robot", "t", *columns) if column not in head]
    if missing:
        raise LogError(f"{path}: row 1: no column {missing[0]!r}; expected run, robot, t, {', '.join(columns)}")


def _numbers(path: Path, column: str, cells: list[Any]) -> FloatArray:
    """A column's numbers; an empty cell is NaN."""
    numbers = np.empty(len(cells))
    for index, cell in enumerate(cells):
        try:
            numbers[index] = math.nan if cell is None or cell == "" else float({"true": 1, "false": 0}.get(str(cell).lower(), cell))
        except ValueError:
            raise LogError(f"{path}: row {index + 2}: {column} is {cell!r}, expected a number") from None
    return numbers


def refuse_missing(where: str, name: str, numbers: FloatArray, columns: tuple[str, ...], *, first: int) -> None:
    """Refuse what cannot be a measurement; missing poses are a tracker that lost the robot, and allowed.

    Args:
        where: Beginning of the error's text, up to the row's number.
        name: Of the table.
        numbers: (N, columns).
        columns: Their names.
        first: Number of the first row.

    Raises:
        LogError: With the row and the reason.
    """
    if not len(numbers):
        return
    bad = np.isinf(numbers)
    if name == "poses":
        bad[:, 0] |= np.isnan(numbers[:, 0])
    else:
        bad |= np.isnan(numbers)
    if name == "detections":
        bad[:, 1] |= ~np.isin(numbers[:, 1], (0.0, 1.0))
    if bad.any():
        row, column = (int(i) for i in np.argwhere(bad)[0])
        expected = "0 or 1" if columns[column] == "detected" else "a finite number"
        raise LogError(f"{where} {row + first}: {columns[column]} is {numbers[row, column]:g}, expected {expected}")


def clean(name: str, where: str, rows: FloatArray, notes: list[str]) -> Rows:
    """Sort by time, drop duplicates, lost and impossible poses, unwrap headings."""
    if np.any(np.diff(rows[:, 0]) < 0):
        notes.append(f"{where}: rows were not in order of time and have been sorted")
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    # of rows of the same time the last is in force
    last = np.append(np.diff(rows[:, 0]) > 0, True)
    if not last.all():
        notes.append(f"{where}: {int((~last).sum())} rows of a time that another row has were dropped")
    rows = rows[last]
    if name == "poses":
        lost = np.isnan(rows).any(axis=1)
        if lost.any():
            notes.append(f"{where}: the tracker lost the robot in {int(lost.sum())} rows")
        rows = rows[~lost]
        rows = _without_jumps(rows, where, notes)
        if len(rows):
            rows[:, 3] = np.unwrap(rows[:, 3])
    return Rows(np.ascontiguousarray(rows[:, 0]), np.ascontiguousarray(rows[:, 1:]))


def _without_jumps(rows: FloatArray, where: str, notes: list[str]) -> FloatArray:
    """Drop single poses that lie where no robot can have gone and come back from, and poses frozen before a jump."""
    if len(rows) < 5:
        return rows
    step = np.hypot(np.diff(rows[:, 1]), np.diff(rows[:, 2]))
    pace = np.diff(rows[:, 0])
    fast = (step > FASTEST * pace) & (step > 0.02)
    bad = np.zeros(len(rows), bool)
    bad[1:-1] = fast[:-1] & fast[1:]
    frozen = np.append(False, (np.diff(rows[:, 1:], axis=0) == 0.0).all(axis=1))
    for jump in np.flatnonzero(step > max(0.02, 10 * float(np.median(step)))):
        back = int(jump)
        while back > 0 and frozen[back]:
            back -= 1
        if jump - back >= 3:
            bad[back + 1 : jump + 1] = True
    if bad.any():
        notes.append(f"{where}: {int(bad.sum())} poses are jumps of the tracker or frozen before one and were dropped")
    return rows[~bad]


def _track(key: tuple[str, str], tables: Mapping[str, Table]) -> Track:
    nothing = {name: Rows(np.empty(0), np.empty((0, len(columns)))) for name, columns in COLUMNS.items()}
    poses, commands, detections = (tables[name].get(key, nothing[name]) for name in ("poses", "commands", "detections"))
    return Track(
        run=key[0], robot=key[1], times=poses.times, poses=poses.values, command_times=commands.times, commands=commands.values,
        detection_times=detections.times, detections=detections.values[:, 0] > 0.5,
    )  # fmt: skip

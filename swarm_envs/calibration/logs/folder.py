"""Logs from a folder with ``log.yaml`` and the tables as CSV or Parquet."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.errors import LogError
from swarm_envs.calibration.logs.log import Log
from swarm_envs.calibration.logs.tables import COLUMNS, Table, as_log, clean, command_scales, refuse_missing


def read_folder(folder: Path) -> Log:
    """Return the log in a folder.

    Raises:
        LogError: When something cannot be used; one line with file, row and reason.
    """
    description = _description(folder / "log.yaml")
    scales, _ = command_scales(description.get("units", {}), folder / "log.yaml")
    notes: list[str] = []
    tables = {name: _table(folder, name, scales, notes) for name in COLUMNS}
    if not tables["commands"]:
        raise LogError(f"{folder}/commands: no rows; a log needs the commands that the robots were given")
    return as_log({"name": folder.name, **description}, tables, folder / "log.yaml", notes)


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

"""The tables of a log: their columns and units, and what is repaired or refused in them, whatever they were read from."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.errors import LogError
from swarm_envs.calibration.logs.log import Log, Track

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

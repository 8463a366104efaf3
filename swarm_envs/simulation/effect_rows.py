"""A robot's effects as compiled code sees them: a record with one number per declared effect, read by the effect's name.

The record's fields are those of the dataclass, so nobody keeps a second list of columns. numba turns ``effects.dead_time`` into a load
from a fixed place, as it does with a constant index, and takes a changed declaration for another type: no cache can be stale.
"""

from __future__ import annotations

import dataclasses
import operator
from collections.abc import Iterable, Sequence
from functools import cache
from typing import Any

import numba
import numpy as np
import numpy.typing as npt

from swarm_envs.worlds import Effects


@cache
def row_type(declaration: type[Effects]) -> np.dtype[Any]:
    """Return the type of a record: one float per field of a dataclass, in the order of declaration.

    The same object each time, by which numba knows it.
    """
    return np.dtype([(field.name, np.float64) for field in dataclasses.fields(declaration)])


def effect_rows(effects: Iterable[Effects]) -> Sequence[Effects]:
    """Return (R,) records with the numbers of R robots.

    Compiled code reads a row as it reads the dataclass, ``rows[i].dead_time``; hence the type.
    """
    of = operator.attrgetter(*(field.name for field in dataclasses.fields(Effects)))  # astuple takes ten times as long
    robots = list(effects)
    models = {id(each): of(each) for each in {id(each): each for each in robots}.values()}  # few, also in a large swarm
    places = {key: place for place, key in enumerate(models)}
    numbers = np.array(list(models.values()), np.float64)[[places[id(each)] for each in robots]]
    rows: Sequence[Effects] = as_rows(numbers, row_type(Effects))
    return rows


def as_rows(numbers: npt.NDArray[np.float64], row: np.dtype[Any]) -> Any:
    """Return numbers (R, E) as (R,) records of a type, without a copy."""
    rows = np.ascontiguousarray(numbers).view(row)[:, 0]
    # not compiled, as in tests of a changed law, numpy's records want to be asked for their fields' names
    return rows.view(np.recarray) if numba.config.DISABLE_JIT else rows

"""A robot's effects as compiled code sees them: a record with one number per declared effect, read by the effect's name.

The record's fields are those of the dataclass, so nobody keeps a second list of columns. numba turns ``effects.dead_time`` into a load
from a fixed place, as it does with a constant index, and takes a changed declaration for another type: no cache can be stale.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Sequence
from typing import Any, TypeVar, cast

import numba
import numpy as np

from swarm_envs.worlds import Effects

E = TypeVar("E", bound=Effects)


def row_type(declaration: type[Effects]) -> np.dtype[Any]:
    """Return the type of an array of records: one float per field of a dataclass, in the order of declaration."""
    return np.dtype([(field.name, np.float64) for field in dataclasses.fields(declaration)])


def effect_rows(effects: Iterable[E], declaration: type[E]) -> Sequence[E]:
    """Return (R,) records with the numbers of R robots.

    Compiled code reads a row as it reads the dataclass, ``rows[i].dead_time``; hence the type.

    Args:
        effects: The robots' effects.
        declaration: Their class.
    """
    numbers = [dataclasses.astuple(each) for each in effects]
    return as_rows(np.array(numbers, np.float64), declaration)


def as_rows(numbers: np.ndarray[Any, np.dtype[np.float64]], declaration: type[E]) -> Sequence[E]:
    """Return numbers (R, E), in the order of the declaration, as (R,) records, without a copy."""
    rows = np.ascontiguousarray(numbers).view(row_type(declaration))[:, 0]
    # not compiled, as in tests of a changed law, numpy's records want to be asked for their fields' names
    return cast(Sequence[E], rows.view(np.recarray) if numba.config.DISABLE_JIT else rows)

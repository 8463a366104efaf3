"""Numbers with a unit, bounds and a source.

A field of a world dataclass is declared with :func:`quantity`; a leaf of a world file is either a plain value, taken to be
in the field's unit, or a mapping ``{value, unit, source, note}``. A unit other than the field's is refused: nothing is
converted silently.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from swarm_envs.worlds.errors import WorldError


@dataclass(frozen=True)
class Provenance:
    """Where a number of a world file comes from."""

    unit: str
    """SI unit as written in the file; ``1`` for a pure number."""
    source: str
    """Paper section, datasheet, measurement or assumption."""
    note: str = ""
    """What a reader should know beside it, such as a value that another source gives."""


def quantity(unit: str, default: Any = dataclasses.MISSING, *, low: float = -math.inf, high: float = math.inf, **more: Any) -> Any:
    """Declare a dataclass field that holds a number (or a nested tuple of numbers) in ``unit``.

    Args:
        unit: SI unit, ``1`` for a pure number.
        default: The field's default; without it the field is required.
        low: Smallest value allowed, inclusive.
        high: Largest value allowed, inclusive.
        **more: What else the field's metadata tells.
    """
    return dataclasses.field(default=default, metadata={"unit": unit, "low": low, "high": high} | more)


LEAF_KEYS = {"value", "unit", "source", "note"}


def is_leaf(node: Any) -> bool:
    """Whether a node of a parsed file is a ``{value, unit, source, note}`` mapping."""
    return isinstance(node, Mapping) and "value" in node


def read_leaf(node: Any, where: str, unit: str) -> tuple[Any, Provenance | None]:
    """Return a leaf's value and its provenance.

    Args:
        node: A plain value or a ``{value, unit, source, note}`` mapping.
        where: File and dotted key, for the error's text.
        unit: The unit that the field expects.

    Raises:
        WorldError: On an unknown key or another unit.
    """
    if not is_leaf(node):
        return node, None
    unknown = sorted(set(node) - LEAF_KEYS)
    if unknown:
        raise WorldError(f"{where}: unknown key {unknown[0]!r} beside 'value'; expected only value, unit, source, note")
    given = str(node.get("unit", unit))
    if given != unit:
        raise WorldError(f"{where}: unit is {given!r}, expected {unit!r}; convert the value and write that unit")
    return node["value"], Provenance(unit, str(node.get("source", "")), str(node.get("note", "")))


def as_numbers(value: Any, where: str, low: float, high: float) -> Any:
    """Return ``value`` as a float or a nested tuple of floats, each finite-checked and within bounds.

    Raises:
        WorldError: When something is not a number, is NaN, or lies outside ``[low, high]``.
    """
    if isinstance(value, list | tuple):
        return tuple(as_numbers(item, f"{where}[{index}]", low, high) for index, item in enumerate(value))
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise WorldError(f"{where}: given {value!r}, expected a number")
    number = float(value)
    if math.isnan(number) or not low <= number <= high:
        raise WorldError(f"{where}: given {value!r}, expected a number {bounds_text(low, high)}")
    return number


def bounds_text(low: float, high: float) -> str:
    """Say an interval in words."""
    if math.isinf(low) and math.isinf(high):
        return "(finite or infinite, not NaN)"
    if math.isinf(high):
        return f"of at least {low:g}"
    if math.isinf(low):
        return f"of at most {high:g}"
    return f"from {low:g} to {high:g}"

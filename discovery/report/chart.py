"""A line chart as SVG, drawn by hand: small, crisp, and in the page's own colours."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Chart:
    """What the template draws; lengths in the SVG's own units."""

    title: str
    x_label: str
    y_label: str
    path: str
    """The line, as an SVG path."""
    x_ticks: list[tuple[float, str]]
    y_ticks: list[tuple[float, str]]
    summary: str
    """The chart in words, for those who do not see it."""
    width: int = 560
    height: int = 280
    left: int = 62
    right: int = 14
    top: int = 14
    bottom: int = 48


def line_chart(xs: Sequence[float], ys: Sequence[float], title: str, x_label: str, y_label: str) -> Chart | None:
    """Return a chart of a line, None when there are not two points."""
    if len(xs) < 2:
        return None
    empty = Chart(title, x_label, y_label, "", [], [], "")
    x_marks, y_marks = _marks(min(xs), max(xs)), _marks(min(ys), max(ys))
    y_low, y_high = min(min(ys), y_marks[0]), max(max(ys), y_marks[-1])

    def place_x(value: float) -> float:
        return empty.left + (value - min(xs)) / (max(xs) - min(xs)) * (empty.width - empty.left - empty.right)

    def place_y(value: float) -> float:
        return empty.height - empty.bottom - (value - y_low) / max(y_high - y_low, 1e-12) * (empty.height - empty.top - empty.bottom)

    points = [f"{place_x(x):.1f} {place_y(y):.1f}" for x, y in zip(xs, ys, strict=True)]
    return Chart(
        title,
        x_label,
        y_label,
        "M" + "L".join(points),
        [(place_x(mark), f"{mark:g}") for mark in x_marks if min(xs) <= mark <= max(xs)],
        [(place_y(mark), f"{mark:g}") for mark in y_marks],
        f"{title}: {y_label} goes from {ys[0]:.3g} to {ys[-1]:.3g} over {x_label}",
    )


def _marks(low: float, high: float) -> list[float]:
    """Round numbers, about five, that span an interval."""
    span = max(high - low, 1e-9)
    rough = span / 4
    unit = 10.0 ** math.floor(math.log10(rough))
    step = next(unit * factor for factor in (1, 2, 5, 10) if unit * factor >= rough)
    first, last = math.floor(low / step), math.ceil(high / step)
    return [round(number * step, 10) for number in range(first, last + 1)]

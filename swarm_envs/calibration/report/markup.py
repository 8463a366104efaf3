"""Numbers, units and tables of the report as HTML."""

from __future__ import annotations

import html
from collections.abc import Sequence


def escaped(value: object) -> str:
    """Return a text as HTML shows it."""
    return html.escape(str(value))


def quantity(value: float, unit: str) -> str:
    """Return a number with its unit, in mm and mrad where it is small."""
    if unit in ("m", "rad", "m/s", "rad/s") and abs(value) < 0.1:
        return f"{1e3 * value:.3g} m{unit}"
    return f"{value:.3g}" if unit == "1" else f"{value:.3g} {unit}"


def p_value(value: float) -> str:
    """Return a p-value with one digit."""
    return "<1e-12" if value < 1e-12 else f"{value:.1g}"


def table(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    """Return a table; nothing where it has no rows."""
    if not rows:
        return ""
    cells = "".join("<tr>" + "".join(f"<td>{escaped(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    names = "".join(f'<th scope="col">{escaped(cell)}</th>' for cell in head)
    return f'<div class="scroll"><table><thead><tr>{names}</tr></thead><tbody>{cells}</tbody></table></div>'


def estimate(value: float, unit: str) -> str:
    """Return an estimate with four digits and its unit."""
    return f"{value:.4g}" if unit == "1" else f"{value:.4g} {unit}"

"""The files that every evaluation writes: a CSV, a JSON and figures as PNG and SVG."""

from __future__ import annotations

import csv
import io
import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from discovery.files.atomic import write_atomically

RULES = "rules"
"""Who gave the labels, where no person did."""


def write_csv(path: Path, head: Sequence[str], rows: Sequence[Sequence[Any]], labels_given_by: str) -> None:
    """Write a table; its last column says who gave the labels."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*head, "labels given by"])
    writer.writerows([*row, labels_given_by] for row in rows)
    write_atomically(path, text.getvalue())


def write_json(path: Path, content: Any) -> None:
    """Write plain data; NaN becomes null."""
    write_atomically(path, json.dumps(_finite(content), indent=2) + "\n")


def write_figure(figure: Any, stem: Path, labels_given_by: str) -> None:
    """Write a matplotlib figure as PNG and SVG; its last line says who gave the labels."""
    figure.supxlabel(f"labels given by {labels_given_by}", fontsize=7, color="#5c6570", x=0.995, ha="right")
    for ending in ("png", "svg"):
        stream = io.BytesIO()
        figure.savefig(stream, format=ending, dpi=110, metadata={"Date": None} if ending == "svg" else None)
        write_atomically(stem.with_suffix(f".{ending}"), stream.getvalue())


def _finite(node: Any) -> Any:
    if isinstance(node, dict):
        return {key: _finite(value) for key, value in node.items()}
    if isinstance(node, list | tuple):
        return [_finite(value) for value in node]
    return None if isinstance(node, float) and not math.isfinite(node) else node

"""How behaviours look in every figure."""

from __future__ import annotations

COLOURS = {
    "aggregation": "#e69f00", "cyclic pursuit": "#0072b2", "dispersal": "#009e73", "milling": "#cc79a7", "wall following": "#d55e00",
    "random": "#8a9099",
}  # fmt: skip
"""Those of the report's ``style.css`` by day."""
SHAPES = {
    "aggregation": "o", "cyclic pursuit": "s", "dispersal": "^", "milling": "D", "wall following": "v", "random": "X",
}  # fmt: skip
"""Marker of each behaviour; the page of maps has the same shapes."""

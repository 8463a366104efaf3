"""How a setting declares its bounds or its choices."""

from __future__ import annotations

import dataclasses
from typing import Any

from omegaconf import MISSING


def number(low: float, high: float = float("inf"), neutral: Any = MISSING) -> Any:
    """Declare a number, or a list of numbers, from ``low`` to ``high``."""
    return dataclasses.field(default=neutral, metadata={"low": low, "high": high})


def choice(*options: str | int, neutral: str | int = MISSING) -> Any:
    """Declare a word or a number out of ``options``."""
    return dataclasses.field(default=neutral, metadata={"options": options})

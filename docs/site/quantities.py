"""What the site says about a number beside its sentence: unit, bounds and neutral value, read from its declaration."""

from __future__ import annotations

import dataclasses
import importlib
from typing import Any

from swarm_envs.worlds.quantity import bounds_text


def declared(name: str) -> str:
    """Return a sentence about a field such as ``swarm_envs.worlds.Effects.dead_time``; empty where it is no declared number."""
    path, _, attribute = name.rpartition(".")
    module, _, owner = path.rpartition(".")
    holder = getattr(importlib.import_module(module), owner, None) if module else None
    field = getattr(holder, "__dataclass_fields__", {}).get(attribute)
    return described(field) if field is not None and "unit" in field.metadata else ""


def described(field: dataclasses.Field[Any]) -> str:
    """Return a declared number's unit and bounds, and for an effect its neutral value and what it acts on."""
    told = field.metadata
    unit = "a pure number" if told["unit"] == "1" else f"in {told['unit']}"
    text = f"{unit[0].upper()}{unit[1:]}, {bounds_text(told['low'], told['high'])}"
    return f"{text}; neutral {field.default:g}; acts on: {told['acts_on'].value}." if "acts_on" in told else f"{text}."

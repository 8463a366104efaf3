"""The data of the behaviour atlas, atlas.json, which :mod:`docs.site.atlas` makes of a run."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

DATA = Path(__file__).with_name("atlas.json")


def read() -> dict[str, Any]:
    """Return the committed data."""
    data: dict[str, Any] = json.loads(DATA.read_text(encoding="utf-8"))
    return data


def controllers(data: dict[str, Any]) -> npt.NDArray[np.float64]:
    """Return the controllers (N, 4) of atlas data, with every bit."""
    return np.frombuffer(base64.b64decode(data["controllers"]), dtype="<f8").reshape(-1, 4)


def labels(data: dict[str, Any]) -> list[str]:
    """Return the N labels of atlas data."""
    return [data["labels"][label] for label in base64.b64decode(data["label"])]


def start_of(data: dict[str, Any], row: int) -> tuple[int, int]:
    """Return the seed of a row's rollout and its index there."""
    generations, indices = (np.frombuffer(base64.b64decode(data[name]), dtype="<u2") for name in ("generations", "indices"))
    return int(data["seeds"][generations[row]]), int(indices[row])

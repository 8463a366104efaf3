"""The labels that rules give, and as numbers: neither safetensors nor pyribs' arrays hold text."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

BEHAVIOURS = ("aggregation", "cyclic pursuit", "dispersal", "milling", "wall following", "random")
"""All of them, in the order of tables and legends; each has its colour in the report's ``style.css``."""
LABEL_BYTES = 32
"""Room for a label's name."""


def encode_labels(labels: list[str]) -> npt.NDArray[np.uint8]:
    """Return labels as bytes (n, LABEL_BYTES)."""
    return np.array([list(text.encode().ljust(LABEL_BYTES, b"\0")) for text in labels], dtype=np.uint8).reshape(-1, LABEL_BYTES)


def decode_labels(codes: npt.NDArray[np.uint8]) -> list[str]:
    """Return what :func:`encode_labels` was given."""
    return [bytes(row).rstrip(b"\0").decode() for row in codes]

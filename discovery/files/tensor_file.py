"""Arrays and metadata in one safetensors file, with a checksum: one file is one atomic step, and damage is noticed."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from discovery.errors import DiscoveryError
from discovery.files.atomic import write_atomically

LABEL = "discovery"
"""Name of the header's entry that says which run, which metadata, and what checksum."""


class DamagedFileError(DiscoveryError):
    """A file of a run folder is not what was written."""


@dataclass(frozen=True)
class TensorFile:
    """What a file holds."""

    tensors: dict[str, npt.NDArray[Any]]
    metadata: dict[str, Any]
    """Numbers, texts and lists: whatever JSON can say."""


def write_tensor_file(path: Path, tensors: Mapping[str, npt.NDArray[Any]], metadata: Mapping[str, Any], run: str) -> None:
    """Write atomically.

    Args:
        path: The file.
        tensors: Arrays by name.
        metadata: Anything that JSON can say.
        run: The run's identity; a file of another run is refused when read.
    """
    arrays = {name: np.ascontiguousarray(array) for name, array in tensors.items()}
    text = json.dumps(dict(metadata))
    # One entry, because safetensors writes several in random order: the same content gives the same bytes.
    label = {"run": run, "sha256": _digest(arrays, text), "facts": text}
    write_atomically(path, save(arrays, {LABEL: json.dumps(label)}))


def read_tensor_file(path: Path, run: str) -> TensorFile:
    """Read and check.

    Raises:
        DamagedFileError: When the file is truncated, altered or belongs to another run.
    """
    try:
        with safe_open(path, framework="numpy") as file:
            label = json.loads((file.metadata() or {}).get(LABEL, "{}"))
            arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 - not a mapping
    except (SafetensorError, OSError, ValueError) as error:
        raise DamagedFileError(f"{path}: not readable ({' '.join(str(error).split())})") from None
    text = label.get("facts", "")
    if label.get("sha256") != _digest(arrays, text):
        raise DamagedFileError(f"{path}: its checksum does not match its content")
    if label.get("run") != run:
        raise DamagedFileError(f"{path}: it belongs to another run")
    return TensorFile(arrays, json.loads(text))


def _digest(arrays: Mapping[str, npt.NDArray[Any]], text: str) -> str:
    digest = hashlib.sha256(text.encode())
    for name in sorted(arrays):
        digest.update(f"{name} {arrays[name].dtype.str} {arrays[name].shape}".encode())
        digest.update(np.ascontiguousarray(arrays[name]).data)
    return digest.hexdigest()

"""Files that are either whole or not there."""

from __future__ import annotations

import contextlib
import errno
import os
from pathlib import Path

from discovery.errors import DiscoveryError


def write_atomically(path: Path, data: bytes | str) -> None:
    """Write a file beside its place, then move it there; a reader never sees half of it.

    Raises:
        DiscoveryError: When the disk is full or the place cannot be written; nothing written earlier is lost.
    """
    content = data.encode() if isinstance(data, str) else data
    # One name per file, not per process: the run folder's lock lets one process write, and a killed one leaves no litter behind.
    temporary = path.with_name(f".{path.name}.partial")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with temporary.open("wb") as file:
            file.write(content)
            file.flush()
            os.fsync(file.fileno())
        os.replace(temporary, path)
    except OSError as error:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise DiscoveryError(_explain(path, len(content), error)) from None


def _explain(path: Path, size: int, error: OSError) -> str:
    if error.errno in (errno.ENOSPC, errno.EDQUOT):
        return f"{path}: the disk is full, {size / 1e6:.1f} MB were to be written; free space and go on"
    return f"{path}: cannot be written ({error.strerror}); make the place writable or choose another with runs=FOLDER"

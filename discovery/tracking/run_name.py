"""The name under which a tracker's server knows a run: kept in the run folder, so that a resumed run finds its own entries."""

from __future__ import annotations

import json
import secrets
from pathlib import Path

from discovery.errors import DiscoveryError
from discovery.files.atomic import write_atomically

FILE = "tracker.json"


def run_name(path: Path, tracker: str) -> str:
    """Return the name of the run in ``path``, made by chance the first time.

    Raises:
        DiscoveryError: When the file is damaged.
    """
    file = path / FILE
    try:
        known = json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}
    except ValueError:
        known = None
    if not isinstance(known, dict) or not all(isinstance(name, str) for name in known.values()):
        raise DiscoveryError(f"{file}: not readable; remove it, and the run is tracked under a new name")
    return str(known[tracker]) if tracker in known else keep_run_name(path, tracker, secrets.token_hex(8))


def keep_run_name(path: Path, tracker: str, name: str) -> str:
    """Keep a name and return it."""
    write_atomically(path / FILE, json.dumps({tracker: name}) + "\n")
    return name

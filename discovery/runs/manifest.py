"""The manifest: what produced a run, so that it can be repeated and doubted."""

from __future__ import annotations

import hashlib
import os
import platform
import subprocess
import sys
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import psutil
import torch

from discovery.runs.run_folder import IDENTITY_VERSION, MANIFEST, RunFolder, notice, read_manifest
from swarm_envs.worlds import WorldSpec

PACKAGES = (
    "swarm-envs", "numpy", "numba", "pymunk", "torch", "torchvision", "lightly", "ribs", "kmedoids", "scikit-learn", "scipy",
    "hydra-core", "safetensors", "pyarrow",
)  # fmt: skip


def begin_manifest(folder: RunFolder, world: WorldSpec) -> dict[str, Any]:
    """Return the manifest of a new run, or that of the run being resumed, with this session added; warn when bits may differ."""
    now = {"versions": _versions(), "machine": _machine(), "world": world_digest(world)}
    manifest = read_manifest(folder.path)
    if manifest is None:
        manifest = {
            "run": folder.identity, "identity_version": IDENTITY_VERSION, "status": "running", "started": _time(), "finished": None,
            "seed": folder.settings.seed,
            "engine": folder.settings.engine, "threads": folder.settings.threads, "git": _git(), **now, "seconds": {}, "sessions": [],
        }  # fmt: skip
    for what in now:
        if manifest[what] != now[what]:
            notice(f"{what} changed since the run began: the result may differ from an uninterrupted run's")
    manifest["sessions"].append({"started": _time(), "command": [Path(sys.executable).name, "-m", "discovery", *sys.argv[1:]]})
    folder.write_json(MANIFEST, manifest)
    return manifest


def end_manifest(folder: RunFolder, manifest: dict[str, Any]) -> None:
    """Mark the run as finished; from now on it is never written again."""
    folder.write_json(MANIFEST, manifest | {"status": "finished", "finished": _time()})


def world_digest(world: WorldSpec) -> str:
    """Return a fingerprint of every number of a world."""
    return hashlib.sha256(repr(world).encode()).hexdigest()[:16]


def _versions() -> dict[str, str]:
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "not installed"
    return found


def _machine() -> dict[str, Any]:
    return {
        "system": f"{platform.system()} {platform.machine()}",
        "processor": _processor(),
        "cores": os.cpu_count(),
        "memory_gb": round(psutil.virtual_memory().total / 1e9, 1),
        "torch_capability": torch.backends.cpu.get_cpu_capability(),
        "gpu": torch.cuda.get_device_name() if torch.cuda.is_available() else None,
    }


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or "unknown"


def _git() -> dict[str, Any] | None:
    """Return commit and dirty flag of the repository that this code stands in, None when there is no git."""

    def ask(*words: str) -> str:
        here = Path(__file__).parent
        return subprocess.run(["git", "-C", str(here), *words], capture_output=True, text=True, check=True, timeout=10).stdout.strip()

    try:
        ask("ls-files", "--error-unmatch", Path(__file__).name)  # installed into an environment in somebody's repository, it is not theirs
        return {"commit": ask("rev-parse", "HEAD"), "dirty": bool(ask("status", "--porcelain", "--untracked-files=no"))}
    except (OSError, subprocess.SubprocessError):
        return None


def _time() -> str:
    return datetime.now(UTC).isoformat(timespec="seconds")

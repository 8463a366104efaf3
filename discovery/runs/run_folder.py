"""One run, one folder: made once, written by one process at a time, never overwritten when finished."""

from __future__ import annotations

import dataclasses
import fcntl
import hashlib
import json
import os
from collections.abc import Iterator, Mapping
from datetime import datetime
from pathlib import Path
from types import TracebackType
from typing import IO, Any, Self

import numpy.typing as npt
from omegaconf import DictConfig, OmegaConf

from discovery.errors import DiscoveryError
from discovery.files.atomic import write_atomically
from discovery.files.tensor_file import DamagedFileError, TensorFile, read_tensor_file, write_tensor_file
from discovery.settings import LOCATION_KEYS, Settings, flat, identity, read_settings, to_yaml
from discovery.tracking.interface import NullTracker, Tracker
from swarm_envs.cores import available_cores

CONFIG, MANIFEST, ARCHIVE, METRICS, ENCODER, COVARIANCE, REPORT = (
    "config.yaml", "manifest.json", "archive.parquet", "metrics.json", "encoder.safetensors", "chance.safetensors", "report.html",
)  # fmt: skip

IDENTITY_VERSION = 2
"""How a run is known from its settings: in version 1 by the text of its config, in today's spelling and order of keys at the time."""

LOCK = ".lock"
OWN_FILES = (LOCK, f".{CONFIG}.partial")
"""What a process that was killed before it wrote the config may have left."""


class RunFolder:
    """The folder of one run, locked while it is open.

    Use :func:`make_folder` or :func:`open_folder` to get one, and ``with`` to lock it.
    """

    def __init__(self, path: Path, settings: Settings, known_by: str | None = None) -> None:
        self.path = path
        self.settings = settings
        self.identity = known_by or identity(settings)
        """What every file of arrays in the folder bears; a folder of an earlier version keeps the one that it was made with."""
        self.tracker: Tracker = NullTracker()
        """Who is told of progress."""
        self._lock: IO[str] | None = None

    def __enter__(self) -> Self:
        self._lock = _lock(self.path)
        return self

    def __exit__(self, kind: type[BaseException] | None, value: BaseException | None, traceback: TracebackType | None) -> None:
        if self._lock is not None:
            self._lock.close()  # the system releases the lock, also when the process is killed

    def write(self, name: str, content: bytes | str) -> Path:
        """Write one file atomically and return its path."""
        write_atomically(self.path / name, content)
        return self.path / name

    def write_json(self, name: str, content: Mapping[str, Any]) -> Path:
        """Write JSON that a person can read."""
        return self.write(name, json.dumps(content, indent=2) + "\n")

    def write_tensors(self, name: str, tensors: Mapping[str, npt.NDArray[Any]], metadata: Mapping[str, Any]) -> None:
        """Write arrays and metadata with a checksum."""
        write_tensor_file(self.path / name, tensors, metadata, self.identity)

    def read_tensors(self, name: str) -> TensorFile | None:
        """Return what :meth:`write_tensors` wrote, None when there is no such file.

        Raises:
            DamagedFileError: When the file is not what was written.
        """
        path = self.path / name
        return read_tensor_file(path, self.identity) if path.exists() else None

    def parts(self, stage: str) -> Iterator[TensorFile]:
        """Yield a stage's numbered parts in order, up to the first that is missing or damaged; that one is made again."""
        for number in range(1_000_000):
            name = part_name(stage, number)
            try:
                part = self.read_tensors(name)
            except DamagedFileError as error:
                notice(f"refused {error}; going on from what came before it")
                return
            if part is None:
                return
            yield part

    def forget_damaged(self, name: str) -> None:
        """Remove a file of arrays that is not what was written, and say so: it is made again from what came before it."""
        try:
            self.read_tensors(name)
        except DamagedFileError as error:
            notice(f"refused {error}; making it again")
            (self.path / name).unlink()

    def remove(self, pattern: str) -> None:
        """Remove files that are no longer needed."""
        for path in self.path.glob(pattern):
            path.unlink()


def part_name(stage: str, number: int) -> str:
    """Name of one numbered part of a stage."""
    return f"{stage}/{number:05d}.safetensors"


def make_folder(settings: Settings) -> RunFolder:
    """Make the folder of a new run and write its config.

    Raises:
        DiscoveryError: When the folder holds something already, or cannot be made.
    """
    # The number of threads decides how sums are split, hence the last bits: it belongs to the run, also when it is resumed elsewhere.
    settled = dataclasses.replace(settings, threads=settings.threads or available_cores())
    path = _made(settings)
    with RunFolder(path, settled) as folder:  # locked: of two processes that make one folder at the same time the second is refused
        if (path / CONFIG).exists():
            if _finished(path):
                raise DiscoveryError(f"{path}: holds a finished run, which is never overwritten; choose another folder")
            raise DiscoveryError(f"{path}: holds an unfinished run; finish it with resume={path} or choose another folder")
        if foreign := sorted(item.name for item in path.iterdir() if item.name not in OWN_FILES):
            (path / LOCK).unlink()
            raise DiscoveryError(f"{path}: is not empty and not a run folder, it has {foreign[0]}; choose another folder")
        folder.write(CONFIG, to_yaml(settled))
    return folder


def open_folder(path: Path, asked: Settings | None = None) -> RunFolder:
    """Open the folder of a run that was begun.

    Args:
        path: The folder.
        asked: The settings that the command asks for; they must be those that the run began with. None takes the run's own.

    Raises:
        DiscoveryError: When it is no run folder, its config or manifest is damaged, or other settings are asked for.
    """
    settings = _read_config(path)
    manifest = read_manifest(path)
    version = IDENTITY_VERSION if manifest is None else manifest.get("identity_version", 1)
    if version not in (1, IDENTITY_VERSION):
        raise DiscoveryError(f"{path / MANIFEST}: of a later version; read it with the version of swarm-envs that it names")
    folder = RunFolder(path, settings, _first_identity(path) if version == 1 else None)
    if manifest is not None and manifest["run"] != folder.identity:
        raise DiscoveryError(f"{path / CONFIG}: was changed since the run began; put it back, or start a new run")
    if asked is not None:
        _refuse_other_settings(path, settings, asked)
    return folder


def refuse_finished(folder: RunFolder) -> None:
    """Refuse to go on with a finished run.

    Raises:
        DiscoveryError: When it is finished.
    """
    if _finished(folder.path):
        raise DiscoveryError(f"{folder.path}: this run is finished, its report is {folder.path / REPORT}; start a new run without resume=")


def read_manifest(path: Path) -> dict[str, Any] | None:
    """Return a run's manifest, None when the run was stopped before it was written.

    Raises:
        DiscoveryError: When it is damaged.
    """
    file = path / MANIFEST
    if not file.exists():
        return None
    try:
        manifest = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise DiscoveryError(f"{file}: not readable ({' '.join(str(error).split())}); put it back, or start a new run") from None
    if not isinstance(manifest, dict) or not {"run", "status"} <= manifest.keys():
        raise DiscoveryError(f"{file}: not a manifest of a run; put it back, or start a new run")
    return manifest


def notice(text: str) -> None:
    """Say something a person should know, without stopping."""
    import sys

    print(f"discovery: {text}", file=sys.stderr, flush=True)


def _finished(path: Path) -> bool:
    manifest = read_manifest(path)
    return manifest is not None and manifest["status"] == "finished"


def _made(settings: Settings) -> Path:
    """Make the folder asked for, or a new one named after time, experiment and seed."""
    stem = f"{datetime.now():%Y-%m-%d_%H-%M-%S}_{settings.name}_seed{settings.seed}"
    path, count = Path(settings.folder) if settings.folder else Path(settings.runs) / stem, 1
    while True:
        try:
            path.mkdir(parents=True, exist_ok=settings.folder is not None)
            return path
        except FileExistsError:
            if settings.folder is not None:
                raise DiscoveryError(f"{path}: is a file; choose another folder") from None
            count += 1  # another run began in the same second
            path = Path(settings.runs) / f"{stem}_{count}"
        except OSError as error:
            raise DiscoveryError(f"{path}: cannot be made ({error.strerror}); choose another place with runs=FOLDER") from None


def _read_config(path: Path) -> Settings:
    file = path / CONFIG
    if not path.is_dir():
        raise DiscoveryError(f"resume={path}: no such folder; give the folder of a run that was stopped")
    try:
        config = OmegaConf.load(file)
        if not isinstance(config, DictConfig):
            raise ValueError("expected a mapping")
        config.update(dict.fromkeys(LOCATION_KEYS) | {"runs": str(path.parent)})
        return read_settings(config)
    except FileNotFoundError:
        raise DiscoveryError(f"resume={path}: not a run folder, it has no {CONFIG}; give the folder of a run that was stopped") from None
    except Exception as error:  # a broken file breaks YAML in many ways; all mean the same to the user
        raise DiscoveryError(f"{file}: not readable ({' '.join(str(error).split())[:200]}); put it back, or start a new run") from None


def _first_identity(path: Path) -> str:
    """Return what a run of an earlier version is known by: its config as it was written, whatever keys are called today."""
    return hashlib.sha256(OmegaConf.to_yaml(OmegaConf.load(path / CONFIG)).encode()).hexdigest()[:16]


def _refuse_other_settings(path: Path, began: Settings, asked: Settings) -> None:
    now = flat(asked)
    for key, value in flat(began).items():
        if key not in LOCATION_KEYS and now[key] != value and (key != "threads" or now[key] is not None):
            raise DiscoveryError(
                f"resume={path}: the run began with {key}={value}, this command says {now[key]}; "
                "repeat the first command, or give resume= alone"
            )


def _lock(path: Path) -> IO[str]:
    try:
        lock = (path / LOCK).open("a+")
    except OSError as error:
        raise DiscoveryError(f"{path}: cannot be written ({error.strerror}); make it writable") from None
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        lock.seek(0)
        holder = lock.read().strip() or "unknown"
        lock.close()
        raise DiscoveryError(f"{path}: process {holder} is writing this run folder; wait for it, or stop it") from None
    lock.truncate(0)
    lock.write(str(os.getpid()))
    lock.flush()
    return lock

"""The command: composes the settings, runs, and turns whatever goes wrong into one line and an exit status."""

from __future__ import annotations

import difflib
import errno
import os
import re
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

import hydra
from hydra.core.hydra_config import HydraConfig
from hydra.errors import HydraException
from omegaconf import DictConfig
from omegaconf.errors import OmegaConfBaseException

from discovery.controllers import check_controllers
from discovery.errors import DiscoveryError
from discovery.runs.run_folder import RunFolder, make_folder, notice, open_folder, refuse_finished
from discovery.settings import Settings, read_settings, setting_names
from discovery.settings.former_names import rename_keys, rename_words
from discovery.tracking import check_tracker
from swarm_envs.simulation import announce_engine
from swarm_envs.worlds import WorldError, load_world

CONFIGS = Path(__file__).parent / "configs"
"""The hydra configs: a link to the repository's ``configs/`` in a checkout, files of the package where it is installed."""

OPTIONS = {
    "-m", "--multirun", "-h", "--help", "--hydra-help", "--version", "-c", "--cfg", "-i", "--info", "--resolve", "-p", "--package",
    "-cd", "--config-dir",
}  # fmt: skip
"""Hydra's options that make sense here; everything else is a setting, key=value."""


def main() -> int:
    """Run the command line and return its exit status: 0 done, 1 something is wrong, 2 wrong usage, 130 and 143 stopped."""
    status, context = 1, RunContext()
    try:
        with _stoppable():
            sys.argv[1:] = with_todays_names(sys.argv[1:])
            _refuse_unknown_options(sys.argv[1:])
            _hydra_main(context)
        return 0
    except DiscoveryError as error:
        reason = str(error)
    except WorldError as error:
        reason = f"world: {error}"
    except (HydraException, OmegaConfBaseException) as error:
        reason = _one_line(error)
    except Stopped as stop:
        status, reason = 128 + stop.signal, "stopped"
    except OSError as error:
        full = error.errno in (errno.ENOSPC, errno.EDQUOT)
        reason = f"{error.filename or 'disk'}: {'the disk is full, free space' if full else error.strerror or error}"
    except MemoryError:
        reason = "out of memory; take fewer videos (dataset.videos) or a smaller batch (representation.batch)"
    hint = f"; finish this run with: python -m discovery resume={context.folder.path}" if context.folder else ""
    print(f"discovery: {reason}{hint}", file=sys.stderr, flush=True)
    return status


class Stopped(BaseException):
    """Ctrl-C or a request to end; every file written so far is whole."""

    def __init__(self, number: int) -> None:
        super().__init__()
        self.signal = number


class RunContext:
    """What the last line needs to know: which folder can be resumed, and what went wrong."""

    folder: RunFolder | None = None
    failure: Exception | None = None


def run(settings: Settings, given: bool, context: RunContext) -> Path:
    """Do one run.

    Args:
        settings: As composed.
        given: Whether the command names settings beside ``resume``; then they must be those that the run began with.
        context: Told the run folder.

    Returns:
        The report's path.
    """
    if settings.resume:
        folder = open_folder(Path(settings.resume), settings if given else None)
        check_tracker(folder.settings)
    else:
        check_tracker(settings)
        check_controllers(load_world(settings.world), settings.search.include)  # a mistake should leave no folder behind
        folder = make_folder(settings)
    with folder:
        refuse_finished(folder)
        context.folder = folder
        announce_engine(folder.settings.world, folder.settings.engine)
        from discovery.pipeline import discover  # torch takes seconds to import: mistakes are told before

        report = discover(folder)
    context.folder = None
    return report


def _hydra_main(context: RunContext) -> None:
    if not (CONFIGS / "config.yaml").is_file():
        raise DiscoveryError(f"{CONFIGS}: no config.yaml there; the installation is incomplete, install swarm-envs again")
    os.environ["HYDRA_FULL_ERROR"] = "1"  # hydra then raises its errors instead of printing them at length

    @hydra.main(config_path=str(CONFIGS), config_name="config", version_base="1.3")
    def job(config: DictConfig) -> None:
        if context.failure is not None:
            return  # the rest of a sweep
        for line in rename_keys(config):  # of a person's own config files
            notice(line)
        overrides = [text for text in HydraConfig.get().overrides.task if not text.startswith(("resume=", "runs=", "folder="))]
        try:
            print(run(read_settings(config), bool(overrides), context), flush=True)
        except Exception as error:  # raised again below: hydra would add lines of its own
            context.failure = error

    job()
    if context.failure is not None:
        raise context.failure


def with_todays_names(words: Sequence[str]) -> list[str]:
    """Return a command's words with the names that settings have today, and say what has changed."""
    renamed, told = rename_words(words)
    for line in told:
        notice(line)
    return renamed


def _refuse_unknown_options(words: list[str]) -> None:
    for word in words:
        if word.startswith("-") and word.split("=")[0] not in OPTIONS:
            raise DiscoveryError(
                f"unknown option {word!r}; settings are written key=value, such as seed=3 (see python -m discovery --help)"
            )


def _one_line(error: Exception) -> str:
    """Say hydra's and omegaconf's many-line errors in one."""
    if unknown := re.match(r"Could not override '(?:\w+@)?([^']+)'", str(error)):
        close = difflib.get_close_matches(unknown[1], setting_names(), 1)
        hint = f"did you mean {close[0]!r}?" if close else "python -m discovery --help lists them"
        return f"unknown setting {unknown[1]!r}; {hint}"
    if missing := re.search(
        r"Could not find '([^/']+)/([^']*)'\s+Available options in '[^']*':\s+(.*?)\s+Config search path", str(error), re.S
    ):
        return f"{missing[1]}: given {missing[2]!r}, expected {' or '.join(missing[3].split())}"
    lines = [" ".join(line.split()) for line in str(error).splitlines()]
    wanted = []
    for line in lines:
        if line.startswith(("Config search path", "full_key", "object_type", "Set the environment")):
            break
        if line and not line.startswith(("To append to your config", "See http")):
            wanted.append(line)
    return "; ".join(wanted) + f"; settings and their choices are in {CONFIGS}, or see python -m discovery --help"


@contextmanager
def _stoppable() -> Iterator[None]:
    """Let Ctrl-C and the request to end stop the run between two files."""

    def stop(number: int, frame: FrameType | None) -> None:
        raise Stopped(number)

    def leave_to_main(error: threading.ExceptHookArgs) -> None:
        if not isinstance(error.exc_value, OSError):
            threading.__excepthook__(error)

    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    # what a library's thread cannot write is told where the main thread waits for it, in one line
    hook, threading.excepthook = threading.excepthook, leave_to_main
    try:
        yield
    finally:
        threading.excepthook = hook
        for number, handler in before.items():
            signal.signal(number, handler)

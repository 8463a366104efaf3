"""Runs of a study, one after the other, each an ordinary discovery run in a process of its own."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from discovery.errors import DiscoveryError
from discovery.evaluation.groups import ASIDE
from discovery.runs.run_folder import CONFIG, make_folder, open_folder, read_manifest
from discovery.settings import LOCATION_KEYS, flat
from docs.studies.discovery_of_behaviours.plan import Planned
from docs.studies.discovery_of_behaviours.stage_reuse import reuse_stages

Runner = Callable[[Planned], None]
"""Finishes a run whose folder is there."""


def finished(path: Path) -> bool:
    """Say whether a folder holds a finished run."""
    manifest = read_manifest(path) if path.is_dir() else None
    return manifest is not None and manifest["status"] == "finished"


def check_folders(planned: Sequence[Planned]) -> None:
    """See that runs which are there are those that the plan asks for.

    Raises:
        DiscoveryError: When one is of other settings, for instance because the plan has been changed since.
    """
    for each in planned:
        if not (each.path / CONFIG).exists():
            continue
        harmless = ("threads", *LOCATION_KEYS) if finished(each.path) else LOCATION_KEYS
        began, now = flat(open_folder(each.path).settings), flat(each.settings)
        for key in sorted(began | now):
            if key not in harmless and not key.startswith(ASIDE) and began.get(key) != now.get(key):
                raise DiscoveryError(
                    f"{each.path}: holds a run with {key}={began.get(key)}, the plan says {now.get(key)}; "
                    f"delete the folder to run it again, or give the entry {each.entry.name} another name"
                )


def run_all(planned: Sequence[Planned], donors: Sequence[Planned], run_one: Runner) -> list[str]:
    """Finish every run that is not; go on with the next when one fails.

    Args:
        planned: What to run, in this order.
        donors: Donor runs, whose stages may be reused.
        run_one: Finishes one.

    Returns:
        One line for each run that failed.
    """
    left = [each for each in planned if not finished(each.path)]
    print(f"runs       {len(planned)} planned, {len(planned) - len(left)} finished already", flush=True)
    failed, began = [], time.monotonic()
    for number, each in enumerate(left):
        name = f"{each.entry.kind}, {each.entry.name}, seed {each.seed}"
        try:
            given = _prepare(each, donors)
            told = f"; {' and '.join(given)} taken from another run" if given else ""
            print(f"\n[{number + 1}/{len(left)}] {name}{told}", flush=True)
            run_one(each)
        except DiscoveryError as error:
            failed.append(f"{name}: {error}")
            print(f"failed     {failed[-1]}", flush=True)
        passed = time.monotonic() - began
        print(f"passed     {_time(passed)}, about {_time(passed / (number + 1) * (len(left) - number - 1))} left", flush=True)
    return failed


def run_in_subprocess(each: Planned) -> None:
    """Finish a run as the command line would, in a process of its own.

    Raises:
        DiscoveryError: When it fails; its own words stand above.
    """
    root = str(Path(__file__).parents[3])
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([root, os.environ.get("PYTHONPATH", "")])}
    command = [sys.executable, "-m", "discovery", *each.words, f"resume={each.path}"]
    status = subprocess.run(command, env=environment, check=False).returncode
    if status in (130, 143, -2, -15):
        raise KeyboardInterrupt
    if status:
        raise DiscoveryError(f"ended with status {status}; see what it said above, and run it alone with {' '.join(command[1:])}")


def _prepare(each: Planned, donors: Sequence[Planned]) -> dict[str, str]:
    """Make or open a run's folder and put into it what donors have made."""
    folder = open_folder(each.path, each.settings) if (each.path / CONFIG).exists() else make_folder(each.settings)
    with folder:
        return reuse_stages(folder, donors)


def _time(seconds: float) -> str:
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 100 else f"{minutes / 60:.1f} h"

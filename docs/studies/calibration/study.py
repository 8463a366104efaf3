"""Hides effects in many logs, asks the calibration to name them, and counts.

``make study-calibration`` or ``python -m docs.studies.calibration`` writes the tables of the page, and to a folder

- ``draws.jsonl``: one line per draw, as it ends; the same command goes on where it was cut off,
- ``draws.csv``: hidden and estimated parameters with their intervals,
- ``study.md``: rates with Wilson intervals, the confusion table and the coverage of the intervals.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict
from pathlib import Path
from typing import Any

import yaml

from docs.studies.calibration.draws import KINDS, Outcome, Task, perform
from docs.studies.calibration.tally import report, table
from docs.studies.marked_page import write_between_marks

PLAN = Path(__file__).with_name("plan.yaml")
"""What the page tells of: the seed, the number of draws of each kind, and the procedures of the lab."""
PAGE = Path(__file__).with_name("index.md")
OUT = Path("build/calibration-study")
"""Folder of the results, under the folder that the command is given in."""
MARK = "results"
"""Of the page: results stand after it."""


def read_outcomes(path: Path) -> list[Outcome]:
    """Outcomes written so far; a line cut off half-way is passed over and its draw done again."""
    outcomes: dict[str, Outcome] = {}
    for line in path.read_text().splitlines() if path.exists() else []:
        try:
            outcome = Outcome(**json.loads(line))
        except (json.JSONDecodeError, TypeError):
            continue
        outcomes[outcome.key] = outcome
    return list(outcomes.values())


def run(tasks: Sequence[Task], out: Path, workers: int) -> list[Outcome]:
    """Perform the tasks that are not done yet, and report on all.

    Args:
        tasks: The draws.
        out: Folder of the results.
        workers: Number of processes.

    Returns:
        The outcomes of the tasks.
    """
    out.mkdir(parents=True, exist_ok=True)
    lines = out / "draws.jsonl"
    wanted = {task.key for task in tasks}
    done = {outcome.key for outcome in read_outcomes(lines)}
    with lines.open("a") as file:
        # closes a line that was cut off; readers pass over empty and broken ones
        file.write("\n")
        for number, outcome in enumerate(_performed([task for task in tasks if task.key not in done], workers), 1):
            file.write(json.dumps(asdict(outcome)) + "\n")
            file.flush()
            hidden = ", ".join([*outcome.hidden, *([outcome.extra] if outcome.extra else [])]) or "nothing"
            named = "FAILED" if outcome.error else ", ".join(outcome.named) or "nothing"
            named += f", rest by {outcome.unexplained}" if outcome.unexplained else ""
            print(f"{number}/{len(wanted - done)} {outcome.kind}: hidden {hidden}; named {named} ({outcome.seconds:.0f} s)", flush=True)
    outcomes = [outcome for outcome in read_outcomes(lines) if outcome.key in wanted]
    (out / "study.md").write_text(report(outcomes))
    (out / "draws.csv").write_text(table(outcomes))
    return outcomes


def write_page(page: Path, results: str) -> None:
    """Put results into a page, without their heading."""
    write_between_marks(page, {MARK: results.partition("\n")[2]})


def _performed(tasks: Sequence[Task], workers: int) -> Iterable[Outcome]:
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context, initializer=os.nice, initargs=(10,)) as pool:
        for future in as_completed([pool.submit(perform, task) for task in tasks]):
            yield future.result()


def main(given: Sequence[str] | None = None) -> None:
    """Run the study from the command line."""
    plan: dict[str, Any] = yaml.safe_load(PLAN.read_text(encoding="utf-8"))
    parser = argparse.ArgumentParser(prog="python -m docs.studies.calibration", description=__doc__.partition("\n")[0])
    for kind in KINDS:
        number = plan["draws"][kind]
        parser.add_argument(f"--{kind}", type=int, default=number, help=f"number of draws (default {number})")
    parser.add_argument("--out", type=Path, default=OUT, help=f"folder of the results (default {OUT})")
    parser.add_argument("--page", type=Path, help=f"page to write into, after a line <!-- {MARK} --> (default: the study's, for its plan)")
    parser.add_argument("--seed", type=int, default=plan["seed"], help="first seed; another one draws other effects and logs")
    parser.add_argument("--workers", type=int, default=2, help="processes (default 2)")
    parser.add_argument("--procedures", nargs="+", choices=["drives", "swarm", "pushes"], default=plan["procedures"])
    arguments = parser.parse_args(given)
    # one thread per worker: linear algebra here is too small to share
    os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))
    drawn = {"seed": arguments.seed, "draws": {kind: getattr(arguments, kind) for kind in KINDS}, "procedures": arguments.procedures}
    tasks = [
        Task(kind, index, arguments.seed * 1_000_000 + 10_000 * place + index, tuple(arguments.procedures))
        for place, kind in enumerate(KINDS)
        for index in range(getattr(arguments, kind))
    ]
    # a study that is cut short has some of each kind
    tasks.sort(key=lambda task: (task.index + 1) / getattr(arguments, task.kind))
    run(tasks, arguments.out, arguments.workers)
    page = arguments.page or (PAGE if drawn == plan else None)
    if page is not None:
        write_page(page, (arguments.out / "study.md").read_text())
    print((arguments.out / "study.md").read_text())

"""Hide effects in many logs, ask the calibration to name them, and count.

``python -m tests.calibration.study --singles 100 --pairs 100 --nulls 100 --out FOLDER`` writes to the folder

- ``draws.jsonl``: one line a draw, as it ends; the same command goes on where it was cut off,
- ``draws.csv``: hidden and estimated parameters with their intervals,
- ``study.md``: rates with Wilson intervals, the confusion table and the coverage of the intervals.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import tempfile
import time
import traceback
from collections.abc import Iterable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from tests.calibration.generator import EFFECTS, UNLISTED, draw, drawn_extra, generate_log
from tests.calibration.tally import DEPENDS_ON, report, table

INSEPARABLE = [{"dead_time", "clock_offset"}]
"""Pairs that are never hidden together: no drive could tell their sizes apart."""
RESULTS = "<!-- results -->"
"""Line of a page after which results stand."""
KINDS = ("singles", "pairs", "nulls", "unlisted")


@dataclass(frozen=True)
class Task:
    """One draw.

    Attributes:
        kind: One of KINDS.
        index: Its number among the draws of its kind.
        seed: Seed of its effects, sizes and log.
        procedures: What the lab may do; effects that only other runs show are not hidden.
    """

    kind: str
    index: int
    seed: int
    procedures: tuple[str, ...]

    @property
    def key(self) -> str:
        """Tells the draw from all others."""
        return f"{self.kind} {self.index} {self.seed} {'+'.join(self.procedures)}"


@dataclass
class Outcome:
    """What came of one draw.

    Attributes:
        key: The task's.
        kind: The task's.
        hidden: Parameters of each hidden effect.
        extra: Name of the unlisted effect, if one was hidden.
        named: For each effect named, each parameter's (estimate, low, high).
        groups: Effects that the calibration calls indistinguishable.
        unexplained: What a remainder depends on, if there is one.
        channel: Which channel it is in.
        cut: Share of the held-out error of the listed effects that the correction takes away at each horizon, of the heading where
            the turn rate is wrong, else of the place.
        cut_world: The same of the world's error, which has no effects.
        sides: Numbers of runs that drive where an effect of place does not act, and where it does.
        seconds: Time that the calibration took, s.
        error: Its traceback, if it failed.
    """

    key: str
    kind: str
    hidden: dict[str, dict[str, float]]
    extra: str | None = None
    named: dict[str, dict[str, tuple[float, float, float]]] = field(default_factory=dict)
    groups: list[list[str]] = field(default_factory=list)
    unexplained: str | None = None
    channel: str | None = None
    cut: list[float] = field(default_factory=list)
    cut_world: list[float] = field(default_factory=list)
    sides: list[int] = field(default_factory=list)
    seconds: float = 0.0
    error: str | None = None


def names_of(task: Task) -> list[str]:
    """The effects that a task hides."""
    number = {"singles": 1, "pairs": 2}.get(task.kind, 0)
    random = np.random.default_rng([task.seed, 4])
    candidates = [name for name, effect in EFFECTS.items() if effect.procedure in task.procedures]
    while True:
        names = [candidates[k] for k in random.choice(len(candidates), number, replace=False)]
        if set(names) not in INSEPARABLE:
            return names


def perform(task: Task) -> Outcome:
    """Write a log, have it identified, and note what was named."""
    # imported here: the study's counting and its tests need no calibration
    from swarm_envs.calibration import read_log
    from swarm_envs.calibration.contact.identification import identify_contact
    from swarm_envs.calibration.drive.identification import identify
    from swarm_envs.calibration.residual.residual_dynamics import find_unlisted
    from swarm_envs.calibration.sensor.identification import identify_sensor
    from swarm_envs.worlds import load_world
    from tests.calibration.sides import runs_on_either_side

    outcome = Outcome(task.key, task.kind, draw(names_of(task), task.seed))
    random = np.random.default_rng([task.seed, 5])
    procedures = None
    if task.kind == "nulls":
        procedures = [task.procedures[random.integers(len(task.procedures))]]
    if task.kind == "unlisted":
        outcome.extra = sorted(UNLISTED)[task.index % len(UNLISTED)]
    with tempfile.TemporaryDirectory() as folder:
        log = generate_log(outcome.hidden, Path(folder) / "log", seed=task.seed, extra=outcome.extra, procedures=procedures)
        began = time.perf_counter()
        try:
            measured, world = read_log(log), load_world("hero_plus")
            if outcome.extra is not None and DEPENDS_ON[outcome.extra] == "place":
                outcome.sides = list(runs_on_either_side(measured, drawn_extra(outcome.extra, task.seed)))
            found = identify(measured, world)
            rest = find_unlisted(measured, found)
            seen = identify_sensor(measured, world, found)
            causes = [cause for cause in found.causes if rest is None or cause.effect not in rest.instead_of]
            touched = identify_contact(measured, world, causes)
        except Exception:
            outcome.error = traceback.format_exc()
        else:
            for cause in (*causes, *seen.causes, *touched.causes):
                outcome.named[cause.effect] = {
                    name: (float(given.estimate), float(given.ci95[0]), float(given.ci95[1])) for name, given in cause.parameters.items()
                }
            outcome.groups = [list(group) for group in (*found.indistinguishable, *seen.indistinguishable, *touched.indistinguishable)]
            if rest is not None:
                outcome.unexplained = rest.discrepancy.depends_on
                outcome.channel = rest.discrepancy.channel
                metric = "heading" if rest.discrepancy.channel == "turn rate" else "position"
                rows = [asdict(row) for row in rest.heldout]
                outcome.cut = [1.0 - row[f"{metric}_after"] / row[f"{metric}_before"] for row in rows]
                outcome.cut_world = [1.0 - row[f"{metric}_after"] / row[f"{metric}_world"] for row in rows]
        outcome.seconds = round(time.perf_counter() - began, 2)
    return outcome


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
    """Put results into a page, in the place of those that it had."""
    text = page.read_text(encoding="utf-8")
    head, mark, _ = text.partition(RESULTS)
    if not mark:
        raise SystemExit(f"{page}: no line {RESULTS!r}, after which the results are to stand")
    page.write_text(f"{head}{RESULTS}\n\n{results.partition(chr(10))[2].strip()}\n", encoding="utf-8")


def _performed(tasks: Sequence[Task], workers: int) -> Iterable[Outcome]:
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context, initializer=os.nice, initargs=(10,)) as pool:
        for future in as_completed([pool.submit(perform, task) for task in tasks]):
            yield future.result()


def main(given: Sequence[str] | None = None) -> None:
    """Run the study from the command line."""
    parser = argparse.ArgumentParser(description="Hide effects in logs and count how often the calibration names them.")
    for kind, number in zip(KINDS, (100, 100, 100, 30), strict=True):
        parser.add_argument(f"--{kind}", type=int, default=number, help=f"number of draws (default {number})")
    parser.add_argument("--out", type=Path, required=True, help="folder of the results")
    parser.add_argument("--page", type=Path, help="Markdown file in which the results are to stand, after a line <!-- results -->")
    parser.add_argument("--seed", type=int, default=0, help="first seed; another one draws other effects and logs")
    parser.add_argument("--workers", type=int, default=2, help="processes (default 2)")
    parser.add_argument("--procedures", nargs="+", choices=["drives", "swarm", "pushes"], default=["drives", "swarm", "pushes"])
    arguments = parser.parse_args(given)
    # one thread a worker: linear algebra here is too small to share
    os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "NUMBA_NUM_THREADS"), "1"))
    tasks = [
        Task(kind, index, arguments.seed * 1_000_000 + 10_000 * place + index, tuple(arguments.procedures))
        for place, kind in enumerate(KINDS)
        for index in range(getattr(arguments, kind))
    ]
    # a study that is cut short has some of each kind
    tasks.sort(key=lambda task: (task.index + 1) / getattr(arguments, task.kind))
    run(tasks, arguments.out, arguments.workers)
    if arguments.page:
        write_page(arguments.page, (arguments.out / "study.md").read_text())
    print((arguments.out / "study.md").read_text())


if __name__ == "__main__":
    main()

"""``make study-discovery_of_behaviours`` or ``python -m docs.studies.discovery_of_behaviours``: its arguments, and what they set going."""

from __future__ import annotations

import argparse
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from discovery.errors import DiscoveryError
from swarm_envs.cores import available_cores
from swarm_envs.worlds import WorldError

PLAN = Path(__file__).with_name("plan.yaml")
PAGE = Path(__file__).with_name("index.md")
"""The page of :data:`PLAN`; another plan's stands beside it, under its name."""


def parser() -> argparse.ArgumentParser:
    """Return the study's arguments."""
    arguments = argparse.ArgumentParser(
        prog="python -m docs.studies.discovery_of_behaviours", description="Run what is not finished, evaluate all that is, write the page."
    )
    arguments.add_argument("--threads", type=int, default=available_cores(), help="cores to use (default: all)")
    arguments.add_argument("--size", choices=("quick", "paper"), default="quick", help="how much training (default: %(default)s)")
    arguments.add_argument("--seeds", type=int, default=5, help="runs of each entry (default: %(default)s)")
    arguments.add_argument(
        "--only",
        nargs="+",
        metavar="NAME",
        help="entries, or kinds of them such as variants, to run; the page is of all that are finished",
    )
    arguments.add_argument("--plan", type=Path, default=PLAN, help="what to run (default: the study's plan.yaml)")
    arguments.add_argument("--out", type=Path, help="folder for runs and evaluations (default: runs/discovery-study-SIZE)")
    arguments.add_argument("--page", type=Path, help="page to write, figures beside it (default: the study's; another plan's beside it)")
    arguments.add_argument("--labels", type=Path, help="a person's labels of the test set, as for representations")
    arguments.add_argument("--list", action="store_true", help="say what is finished and what is not, and end")
    arguments.add_argument("--no-evaluation", action="store_true", help="run, but neither evaluate nor write the page")
    return arguments


def main(given: Sequence[str] | None = None) -> int:
    """Run the study; returns its exit status."""
    arguments = parser().parse_args(given)
    try:
        run_study(arguments)
    except KeyboardInterrupt:
        print("study: stopped; the same command goes on where it was", file=sys.stderr)
        return 130
    except (DiscoveryError, WorldError, OSError) as error:
        print(f"study: {error}", file=sys.stderr)
        return 1
    return 0


def run_study(arguments: argparse.Namespace) -> None:
    """Run what is not finished, evaluate all that is, and write the page.

    Raises:
        DiscoveryError: When a run failed, after everything else was done.
    """
    from docs.studies.discovery_of_behaviours.plan import choose, plan_runs, read_plan
    from docs.studies.discovery_of_behaviours.running import check_folders, finished, run_all, run_in_subprocess

    if arguments.seeds < 1:
        raise DiscoveryError(f"--seeds: given {arguments.seeds}, expected at least 1")
    plan = read_plan(arguments.plan, arguments.size)
    chosen = choose(plan, arguments.only)
    out = arguments.out or Path("runs") / f"discovery-study-{arguments.size}"
    everything = plan_runs(plan, plan.entries, arguments.seeds, out, arguments.threads)
    check_folders(everything)
    if arguments.list:
        for each in everything:
            state = "finished" if finished(each.path) else "begun" if each.path.exists() else "missing"
            print(f"{state:<9} {each.entry.kind:<16} {each.entry.name:<28} seed {each.seed}")
        return
    from docs.studies.discovery_of_behaviours.weights import without_weights

    left_out = without_weights(plan)
    names = {entry.name for entry in chosen} - set(left_out)
    for name, reason in left_out.items():
        print(f"left out   {name}: {reason}", flush=True)
    with _ended_with_what_it_runs():
        failed = run_all([each for each in everything if each.entry.name in names], everything, run_in_subprocess)
    if not arguments.no_evaluation:
        import torch

        from docs.studies.discovery_of_behaviours.evaluating import Evaluations
        from docs.studies.discovery_of_behaviours.page import write_page

        torch.set_num_threads(arguments.threads)
        evaluations = Evaluations(plan, everything, out / "evaluations", arguments.threads, arguments.labels)
        evaluations.make()
        page = arguments.page or (PAGE if arguments.plan.resolve() == PLAN.resolve() else arguments.plan.with_suffix(".md"))
        write_page(page, plan, evaluations, left_out, arguments.seeds)
        print(page)
    if failed:
        raise DiscoveryError(f"{len(failed)} of the runs failed, the first is {failed[0]}")


@contextmanager
def _ended_with_what_it_runs() -> Iterator[None]:
    """Let a request to end reach the run too, as Ctrl-C does: otherwise it would go on alone and hold its folder."""

    def end(number: int, frame: FrameType | None) -> None:
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGTERM, end)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)

"""``python -m discovery.evaluation study``: its arguments, and what they set going."""

from __future__ import annotations

import argparse
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from discovery.command import CONFIGS
from discovery.errors import DiscoveryError

STUDY = CONFIGS.parent / "docs" / "studies" / "discovery_of_behaviours.yaml"
"""The study's plan; its page stands beside it."""


def add_study(arguments: argparse.ArgumentParser) -> None:
    """Declare the study's arguments."""
    arguments.add_argument("--size", choices=("quick", "paper"), default="quick", help="how much training (default: %(default)s)")
    arguments.add_argument("--seeds", type=int, default=5, help="runs of each entry (default: %(default)s)")
    arguments.add_argument(
        "--only",
        nargs="+",
        metavar="NAME",
        help="entries, or kinds of them such as variants, to run; the page is of all that are finished",
    )
    arguments.add_argument("--plan", type=Path, default=STUDY, help="what to run (default: docs/studies/discovery_of_behaviours.yaml)")
    arguments.add_argument("--out", type=Path, help="folder for runs and evaluations (default: runs/discovery-study-SIZE)")
    arguments.add_argument("--page", type=Path, help="page to write, figures beside it (default: beside the plan)")
    arguments.add_argument("--labels", type=Path, help="a person's labels of the test set, as for representations")
    arguments.add_argument("--list", action="store_true", help="say what is finished and what is not, and end")
    arguments.add_argument("--no-evaluation", action="store_true", help="run, but neither evaluate nor write the page")


def run_study(arguments: argparse.Namespace) -> None:
    """Run what is not finished, evaluate all that is, and write the page.

    Raises:
        DiscoveryError: When a run failed, after everything else was done.
    """
    from discovery.evaluation.study.plan import choose, plan_runs, read_plan
    from discovery.evaluation.study.running import finished, run_all, run_apart

    if arguments.seeds < 1:
        raise DiscoveryError(f"--seeds: given {arguments.seeds}, expected at least 1")
    plan = read_plan(arguments.plan, arguments.size)
    chosen = choose(plan, arguments.only)
    out = arguments.out or Path("runs") / f"discovery-study-{arguments.size}"
    everything = plan_runs(plan, plan.entries, arguments.seeds, out, arguments.threads)
    if arguments.list:
        for each in everything:
            state = "finished" if finished(each.path) else "begun" if each.path.exists() else "missing"
            print(f"{state:<9} {each.entry.kind:<16} {each.entry.name:<28} seed {each.seed}")
        return
    from discovery.evaluation.study.weights import without_weights

    left_out = without_weights(plan)
    names = {entry.name for entry in chosen} - set(left_out)
    for name, reason in left_out.items():
        print(f"left out   {name}: {reason}", flush=True)
    with _ended_with_what_it_runs():
        failed = run_all([each for each in everything if each.entry.name in names], everything, run_apart)
    if not arguments.no_evaluation:
        import torch

        from discovery.evaluation.study.evaluating import Evaluations
        from discovery.evaluation.study.page import write_page

        torch.set_num_threads(arguments.threads)
        evaluations = Evaluations(plan, everything, out / "evaluations", arguments.threads, arguments.labels)
        evaluations.make()
        page = arguments.page or arguments.plan.with_suffix(".md")
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

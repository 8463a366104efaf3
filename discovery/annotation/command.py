"""``python -m discovery.annotation``: judge the rollouts of a finished run on a page in the browser; answers are kept one by one."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import getpass
import signal
import sys
from collections.abc import Sequence
from pathlib import Path

from discovery.errors import DiscoveryError
from swarm_envs.worlds import WorldError


def parser() -> argparse.ArgumentParser:
    """Return the command's arguments."""
    arguments = argparse.ArgumentParser(prog="python -m discovery.annotation", description=__doc__)
    arguments.add_argument(
        "kind",
        choices=("triples", "labels"),
        help="triples: which of two is more like a third (for representation=triplet); labels: what a test rollout shows (for evaluation)",
    )
    arguments.add_argument("run", type=Path, help="folder of a finished run")
    arguments.add_argument("--out", type=Path, required=True, help="file for the answers; one that exists is gone on with")
    arguments.add_argument("--wanted", type=int, help="answers to ask for (default: 500 triples, or every test rollout)")
    arguments.add_argument("--name", default=getpass.getuser(), help="who answers (default: %(default)s)")
    arguments.add_argument("--per-class", type=int, default=100, help="of the test set, as in evaluation (default: %(default)s)")
    arguments.add_argument("--most-draws", type=int, default=8000, help="of the test set, as in evaluation (default: %(default)s)")
    arguments.add_argument("--seed", type=int, default=0, help="of the test set and of the questions (default: %(default)s)")
    arguments.add_argument("--port", type=int, default=8090, help="of the page; 0 takes a free one (default: %(default)s)")
    return arguments


def main(given: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    arguments = parser().parse_args(given)
    try:
        asyncio.run(_serve(arguments))
    except KeyboardInterrupt:  # before the page was there
        return 130
    except (DiscoveryError, WorldError, OSError) as error:
        print(f"discovery.annotation: {error}", file=sys.stderr)
        return 1
    return 0


async def _serve(arguments: argparse.Namespace) -> None:
    from discovery.saved_run import load_run

    run = load_run(arguments.run)
    try:
        from discovery.annotation.server import AnnotationPage
    except ImportError as error:
        raise DiscoveryError(f"{error}; install swarm-envs[fleet], which has the web server") from None
    from discovery.annotation.answers import open_answers
    from discovery.annotation.clips import Clips, LabelledClips, dataset_clips
    from discovery.rollouts.simulator import Simulator
    from discovery.rollouts.test_set import draw_test_set
    from discovery.runs.run_folder import open_folder
    from swarm_envs.worlds import load_world

    settings = run.settings
    simulator = Simulator(load_world(settings.world), settings.engine, settings.steps, 1)
    clips: Clips
    if arguments.kind == "labels":
        clips = LabelledClips(draw_test_set(simulator, arguments.per_class, arguments.most_draws, arguments.seed))
    else:
        clips = dataset_clips(open_folder(arguments.run), simulator)
    answers = open_answers(arguments.out, arguments.kind, clips.fingerprint, arguments.name)
    wanted = arguments.wanted or (len(clips) if arguments.kind == "labels" else 500)
    page = AnnotationPage(clips, answers, wanted, arguments.seed)
    print(f"{await page.open(arguments.port)}  (Ctrl-C ends; every answer is already in {arguments.out})", flush=True)
    for number in (signal.SIGINT, signal.SIGTERM):
        with contextlib.suppress(NotImplementedError):  # Windows: Ctrl-C ends the program all the same
            asyncio.get_running_loop().add_signal_handler(number, page.ended.set)
    try:
        await page.ended.wait()
        await asyncio.sleep(1.0)  # the page may still ask what comes next
        print(f"{len(answers.given)} answers in {arguments.out}")
    finally:
        await page.close()

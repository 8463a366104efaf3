"""``python -m discovery.evaluation``: what finished runs are worth, with figures, a CSV and a JSON."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from discovery.errors import DiscoveryError
from swarm_envs.cores import available_cores
from swarm_envs.worlds import WorldError

if TYPE_CHECKING:
    from discovery.rollouts.simulator import Simulator
    from discovery.rollouts.test_set import LabelledTestSet
    from discovery.saved_run import Run


STUDY = "make study-discovery_of_behaviours, or python -m docs.studies.discovery_of_behaviours, in a checkout of the repository"
"""What runs the study, which this command ran until version 0.1."""


def parser() -> argparse.ArgumentParser:
    """Return the command's arguments."""
    top = argparse.ArgumentParser(prog="python -m discovery.evaluation", description=__doc__)
    kinds = top.add_subparsers(dest="kind", required=True)
    shared = argparse.ArgumentParser(add_help=False)
    shared.add_argument("--threads", type=int, default=available_cores(), help="cores to use (default: all)")
    shared.add_argument("runs", nargs="+", type=Path, help="folders of finished runs; seeds of one representation go together")
    shared.add_argument("--out", type=Path, required=True, help="folder for the figures and tables")
    tested = argparse.ArgumentParser(add_help=False)
    tested.add_argument("--per-class", type=int, default=100, help="test rollouts of each behaviour (default: %(default)s)")
    tested.add_argument("--most-draws", type=int, default=8000, help="rollouts simulated at most to find them (default: %(default)s)")
    tested.add_argument("--labels", type=Path, help="a person's labels, from python -m discovery.annotation labels, instead of the rules'")
    tested.add_argument("--seed", type=int, default=0, help="of the test set (default: %(default)s)")
    kinds.add_parser(
        "representations", parents=[shared, tested], help="confusion over held-out triplets (Figure 3), k-NN, linear probe; one world"
    )
    maps = kinds.add_parser("tsne", parents=[shared, tested], help="t-SNE of the test set (Figure 4), as figures and a page; one world")
    maps.add_argument("--iterations", type=int, default=1000, help="of t-SNE, at least 250 (default: %(default)s)")
    found = kinds.add_parser("behaviours", parents=[shared], help="which behaviours the medoids are (Table 1), and what simpler ways find")
    found.add_argument("--no-random-search", action="store_true", help="leave out random sampling, which simulates again")
    moved = kinds.add_parser("transfer", parents=[shared], help="which behaviours found in one world survive in another (Table 2)")
    moved.add_argument("--to", default="hero_plus", help="the world that stands for the robots (default: %(default)s)")
    moved.add_argument("--starts", type=int, default=20, help="attempts of each medoid (default: %(default)s)")
    return top


def main(given: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    words = list(sys.argv[1:] if given is None else given)
    if words[:1] == ["study"]:
        return _forward_study(words[1:])
    arguments = parser().parse_args(words)
    try:
        _evaluate(arguments)
    except KeyboardInterrupt:
        print("discovery.evaluation: stopped; the same command goes on where it was", file=sys.stderr)
        return 130
    except (DiscoveryError, WorldError, OSError) as error:
        print(f"discovery.evaluation: {error}", file=sys.stderr)
        return 1
    return 0


def _evaluate(arguments: argparse.Namespace) -> None:
    {
        "representations": _representations, "tsne": _maps, "behaviours": _behaviours, "transfer": _transfer,
    }[arguments.kind](arguments)  # fmt: skip


def _representations(arguments: argparse.Namespace) -> None:
    groups, simulator = _open(arguments)
    from discovery.evaluation.representations import score_representations, write_representations

    test = _test_set(arguments, simulator)
    scores = score_representations(groups, test)
    write_representations(arguments.out, scores, test)
    for entry in scores:
        numbers = f"triplets {entry.accuracy[0]:.3f}, k-NN {entry.knn[0]:.3f}, linear {entry.linear[0]:.3f}"
        print(f"{entry.name}: {numbers}, {entry.runs} runs")


def _maps(arguments: argparse.Namespace) -> None:
    groups, simulator = _open(arguments)
    from discovery.evaluation.maps import lay_out_maps, write_maps

    test = _test_set(arguments, simulator)
    write_maps(arguments.out, lay_out_maps(groups, test, max(250, arguments.iterations), arguments.seed), test)
    print(arguments.out / "tsne.html")


def _behaviours(arguments: argparse.Namespace) -> None:
    groups, simulator = _open(arguments)
    from discovery.evaluation.frequency import RANDOM, count_behaviours, write_frequency

    found = count_behaviours(groups, None if arguments.no_random_search else simulator)
    write_frequency(arguments.out, found)
    for way in found:
        unique, chance = (sum(counts) / len(way.labels) for counts in (way.unique, way.count(RANDOM)))
        print(f"{way.name}: {unique:.2f} unique, {chance:.2f} random")


def _transfer(arguments: argparse.Namespace) -> None:
    from discovery.saved_run import load_run

    runs = [load_run(folder) for folder in arguments.runs]
    from discovery.evaluation.transfer import transfer
    from discovery.evaluation.transfer_tables import survival, write_transfer

    found = transfer(runs, arguments.to, arguments.starts, arguments.threads)
    arguments.out.mkdir(parents=True, exist_ok=True)
    write_transfer(arguments.out, found, arguments.to)
    for entry in survival(found):
        first = " and ".join(f"{count} by {way}" for way, count in entry.first.items())
        print(f"{entry.world}: {entry.medoids} medoids other than random in {entry.runs} runs; survive at the first attempt: {first}")


def _forward_study(words: Sequence[str]) -> int:
    """Hand a study over to the checkout that this package lies in. Deprecated: goes with the next version."""
    root = Path(__file__).parents[2]
    if not (root / "docs" / "studies" / "discovery_of_behaviours").is_dir():
        print(f"discovery.evaluation: given study, which is no part of this package any more; run {STUDY}", file=sys.stderr)
        return 2
    print(f"discovery.evaluation: study is deprecated here; run {STUDY}", file=sys.stderr, flush=True)
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(root), os.environ.get("PYTHONPATH", "")])}
    os.execve(sys.executable, [sys.executable, "-m", "docs.studies.discovery_of_behaviours", *words], environment)


def _open(arguments: argparse.Namespace) -> tuple[dict[str, list[Run]], Simulator]:
    """Return the runs and the simulator of their world."""
    from discovery.evaluation.groups import load_groups

    groups = load_groups(arguments.runs)  # before torch, which takes seconds to import: mistakes are told first
    settings = next(iter(groups.values()))[0].settings
    import torch

    from discovery.rollouts.simulator import Simulator
    from swarm_envs.worlds import load_world

    torch.set_num_threads(arguments.threads)
    arguments.out.mkdir(parents=True, exist_ok=True)
    return groups, Simulator(load_world(settings.world), settings.engine, settings.steps, arguments.threads)


def _test_set(arguments: argparse.Namespace, simulator: Simulator) -> LabelledTestSet:
    from discovery.annotation.answers import read_labels
    from discovery.rollouts.test_set import draw_test_set

    test = draw_test_set(simulator, arguments.per_class, arguments.most_draws, arguments.seed)
    return test if arguments.labels is None else test.relabelled(*read_labels(arguments.labels, test.fingerprint))

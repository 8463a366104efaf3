"""``python -m discovery.evaluation``: what finished runs are worth, with figures, a CSV and a JSON."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from discovery.errors import DiscoveryError
from swarm_envs.worlds import WorldError

if TYPE_CHECKING:
    from discovery.saved_run import Run
    from discovery.simulate import Simulator


def parser() -> argparse.ArgumentParser:
    """Return the command's arguments."""
    top = argparse.ArgumentParser(prog="python -m discovery.evaluation", description=__doc__)
    kinds = top.add_subparsers(dest="kind", required=True)
    shared = argparse.ArgumentParser(add_help=False)
    shared.add_argument("runs", nargs="+", type=Path, help="folders of finished runs of one world; seeds of one representation go together")
    shared.add_argument("--out", type=Path, required=True, help="folder for the figures and tables")
    shared.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)), help="cores to use (default: all)")
    one = kinds.add_parser("representations", parents=[shared], help="confusion over held-out triplets (Figure 3), k-NN, linear probe")
    one.add_argument("--per-class", type=int, default=100, help="test rollouts of each behaviour (default: %(default)s)")
    one.add_argument("--most-draws", type=int, default=8000, help="rollouts simulated at most to find them (default: %(default)s)")
    one.add_argument("--labels", type=Path, help="a person's labels, from python -m discovery.annotation labels, instead of the rules'")
    one.add_argument("--seed", type=int, default=0, help="of the test set (default: %(default)s)")
    two = kinds.add_parser("behaviours", parents=[shared], help="which behaviours the medoids are (Table 1), and what simpler ways find")
    two.add_argument("--no-random-search", action="store_true", help="leave out random sampling, which simulates anew")
    return top


def main(given: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    arguments = parser().parse_args(given)
    try:
        _evaluate(arguments)
    except (DiscoveryError, WorldError, OSError) as error:
        print(f"discovery.evaluation: {error}", file=sys.stderr)
        return 1
    return 0


def _evaluate(arguments: argparse.Namespace) -> None:
    from discovery.evaluation.groups import load_groups

    groups = load_groups(arguments.runs)  # before torch, which takes seconds to import: mistakes are told first
    settings = next(iter(groups.values()))[0].settings
    import torch

    from discovery.simulate import Simulator
    from swarm_envs.worlds import load_world

    torch.set_num_threads(arguments.threads)
    simulator = Simulator(load_world(settings.world), settings.engine, settings.steps, arguments.threads)
    arguments.out.mkdir(parents=True, exist_ok=True)
    {"representations": _representations, "behaviours": _behaviours}[arguments.kind](arguments, groups, simulator)


def _representations(arguments: argparse.Namespace, groups: dict[str, list[Run]], simulator: Simulator) -> None:
    from discovery.annotation.answers import read_labels
    from discovery.evaluation.representations import judge_representations, write_representations
    from discovery.held_out import draw_held_out

    test = draw_held_out(simulator, arguments.per_class, arguments.most_draws, arguments.seed)
    if arguments.labels is not None:
        test = test.relabelled(*read_labels(arguments.labels, test.fingerprint))
    judged = judge_representations(groups, test)
    write_representations(arguments.out, judged, test)
    for entry in judged:
        numbers = f"triplets {entry.accuracy[0]:.3f}, k-NN {entry.knn[0]:.3f}, linear {entry.linear[0]:.3f}"
        print(f"{entry.name}: {numbers}, {entry.runs} runs")


def _behaviours(arguments: argparse.Namespace, groups: dict[str, list[Run]], simulator: Simulator) -> None:
    from discovery.evaluation.frequency import RANDOM, medoids_found, random_search, standardised_medoids, write_frequency

    found = []
    for name, runs in groups.items():
        found += [medoids_found(name, runs), standardised_medoids(name, runs)]
        if not arguments.no_random_search:
            found.append(random_search(name, runs, simulator))
    write_frequency(arguments.out, found)
    for way in found:
        unique, chance = (sum(counts) / len(way.labels) for counts in (way.unique, way.count(RANDOM)))
        print(f"{way.name}: {unique:.2f} unique, {chance:.2f} random")

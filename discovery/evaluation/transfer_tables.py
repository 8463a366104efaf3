"""What :mod:`discovery.evaluation.transfer` found, as tables and a figure."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from discovery.evaluation import published
from discovery.evaluation.frequency import RANDOM
from discovery.evaluation.groups import interval
from discovery.evaluation.tables import RULES, write_csv, write_figure, write_json
from discovery.evaluation.transfer import ATTEMPTS, Flags, Transferred, mark, within
from discovery.rollouts.labels import BEHAVIOURS

WAYS: dict[str, Callable[[Transferred], Flags]] = {"label": lambda each: each.by_label, "metrics": lambda each: each.by_metrics}
"""How a medoid's attempts are judged."""


@dataclass(frozen=True)
class Survival:
    """Medoids of one world, random ones not counted; shares are means over runs, with 95 % intervals over them."""

    world: str
    runs: int
    medoids: int
    first: dict[str, int]
    """Medoids whose first attempt succeeded, by way."""
    within_three: dict[str, int]
    """Medoids of which one of the first three attempts succeeded, by way."""
    one_attempt: dict[str, tuple[float, float, float]]
    """Share of all attempts that succeeded, by way: mean and interval."""
    three_attempts: dict[str, tuple[float, float, float]]
    """Probability that one of three attempts succeeds, by way: mean and interval."""
    home: tuple[float, float, float]
    """Share of new runs at home that have the label again."""


def worlds_of(found: list[Transferred]) -> list[str]:
    """Return the worlds in the order in which they were judged."""
    return list(dict.fromkeys(each.world for each in found))


def survival(found: list[Transferred]) -> list[Survival]:
    """Sum up, world by world."""
    return [_sum_up(world, [each for each in found if each.world == world]) for world in worlds_of(found)]


def _sum_up(world: str, found: list[Transferred]) -> Survival:
    seeds = sorted({each.seed for each in found})
    named = [each for each in found if each.label != RANDOM]

    return Survival(
        world, len(seeds), len(named),
        {way: sum(bool(told(each)[0]) for each in named) for way, told in WAYS.items()},
        {way: sum(bool(told(each)[:ATTEMPTS].any()) for each in named) for way, told in WAYS.items()},
        {way: _over_runs(named, partial(_chance, told, 1)) for way, told in WAYS.items()},
        {way: _over_runs(named, partial(_chance, told, ATTEMPTS)) for way, told in WAYS.items()},
        _over_runs(named, lambda each: each.at_home),
    )  # fmt: skip


def _chance(told: Callable[[Transferred], Flags], tries: int, each: Transferred) -> float:
    return within(told(each), tries)


def marks(found: list[Transferred], way: str) -> dict[str, dict[str, dict[int, str]]]:
    """Return Table 2: marks by world, behaviour and the run's seed; - where a run did not find the behaviour."""
    table: dict[str, dict[str, dict[int, str]]] = {}
    for world in worlds_of(found):
        seeds = sorted({each.seed for each in found if each.world == world})
        table[world] = {}
        for name in (name for name in BEHAVIOURS if name != RANDOM):
            cells = {seed: [mark(WAYS[way](e)) for e in found if (e.world, e.label, e.seed) == (world, name, seed)] for seed in seeds}
            table[world][name] = {seed: "".join(sorted(each, key="✓◐✗".index)) or "-" for seed, each in cells.items()}
    return table


def write_transfer(folder: Path, found: list[Transferred], target: str) -> None:
    """Write ``transfer.csv`` (a row for each medoid), ``.json``, ``.png`` and ``.svg``."""
    head = [
        "world", "seed", "medoid", "behaviour", "v0", "w0", "v1", "w1", "slowed", "same label at home", "by label, mark", "by label, share",
        "by metrics, mark", "by metrics, share", "largest distance allowed", "median distance",
    ]  # fmt: skip
    rows = [
        [
            each.world, each.seed, each.number, each.label, *each.controller.tolist(), each.slowed, each.at_home,
            mark(each.by_label), float(each.by_label.mean()), mark(each.by_metrics), float(each.by_metrics.mean()),
            each.threshold, float(np.median(each.distances)),
        ]
        for each in found
    ]  # fmt: skip
    write_csv(folder / "transfer.csv", head, rows, RULES)
    summary = survival(found)
    write_json(
        folder / "transfer.json",
        {
            "labels_given_by": RULES,
            "target": target,
            "starts": len(found[0].labels),
            "survives": {
                "by label": "an attempt has the medoid's label",
                "by metrics": "an attempt's mean distance to the runs at home is at most the 95th percentile of theirs to one another",
            },
            "survival": [vars(entry) for entry in summary],
            "table": {way: marks(found, way) for way in WAYS},
            "behaviours": by_behaviour(found),
            "paper": {"table": published.DEPLOYED, "success_at_first_and_within_three": published.SUCCESS},
            "medoids": [
                {
                    "world": each.world, "seed": each.seed, "medoid": each.number, "label": each.label, "slowed": each.slowed,
                    "controller": each.controller.tolist(), "home_labels": each.home_labels, "labels": each.labels,
                    "home_distances": each.home_distances.tolist(), "distances": each.distances.tolist(), "threshold": each.threshold,
                }
                for each in found
            ],
        },
    )  # fmt: skip
    write_figure(draw(summary), folder / "transfer", RULES)


def by_behaviour(found: list[Transferred]) -> dict[str, dict[str, dict[str, Any]]]:
    """Return, by world and behaviour, how many medoids of how many runs, and what share of their attempts succeeds.

    Shares are means over the runs that found the behaviour, each with its 95 % interval over them.
    """
    table: dict[str, dict[str, dict[str, Any]]] = {}
    for world in worlds_of(found):
        table[world] = {}
        for name in BEHAVIOURS:
            medoids = [each for each in found if (each.world, each.label) == (world, name)]
            if medoids:
                table[world][name] = {
                    "medoids": len(medoids), "runs": len({each.seed for each in medoids}),
                    **{way: _over_runs(medoids, partial(_chance, told, 1)) for way, told in WAYS.items()},
                    "at_home": _over_runs(medoids, lambda each: each.at_home),
                }  # fmt: skip
    return table


def _over_runs(medoids: list[Transferred], number: Callable[[Transferred], float]) -> tuple[float, float, float]:
    """Return mean and 95 % interval over runs of a run's mean over its medoids."""
    seeds = sorted({each.seed for each in medoids})
    return interval([float(np.mean([number(each) for each in medoids if each.seed == seed])) for seed in seeds])


def draw(summary: list[Survival]) -> Any:
    """Return a figure: by world, how often one attempt succeeds, by label and by metrics, with intervals and the paper's robots beside."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 0.75 * len(summary) + 1.4), layout="constrained")
    axis = figure.subplots()
    rows = np.arange(len(summary))
    for way, shift, colour, shape in (("label", -0.17, "#0072b2", "o"), ("metrics", 0.0, "#e69f00", "s")):
        means, lows, highs = np.array([entry.one_attempt[way] for entry in summary]).T
        spread = np.nan_to_num(np.abs(np.stack([means - lows, highs - means])))
        axis.errorbar(100 * means, rows + shift, xerr=100 * spread, fmt=shape, color=colour, capsize=4, label=f"same by {way}")
    home = np.array([entry.home[0] for entry in summary])
    axis.plot(100 * home, rows + 0.17, "|", color="#5c6570", markersize=11, label="same label again at home")
    theirs = [(100 * published.SUCCESS[entry.world][0], row) for row, entry in enumerate(summary) if entry.world in published.SUCCESS]
    if theirs:
        axis.plot(*zip(*theirs, strict=True), "D", color="#1d2126", fillstyle="none", label="paper, real robots")
    axis.set_yticks(rows, [f"{entry.world}\nmedoids: {entry.medoids}, runs: {entry.runs}" for entry in summary])
    axis.invert_yaxis()
    axis.set_xlim(-3, 103)
    axis.set_xlabel("attempts that succeed (%), mean and 95 % interval over runs")
    axis.grid(axis="x", alpha=0.3)
    figure.legend(loc="outside upper right", ncols=4, fontsize=8, frameon=False)
    return figure

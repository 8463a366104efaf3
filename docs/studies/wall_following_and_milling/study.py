"""How often do wall following and milling arise from random controllers, with and without the paper's measurements?

``make study-wall_following_and_milling`` or ``python -m docs.studies.wall_following_and_milling`` writes the tables and the figure of the
page.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import sys
from collections import Counter
from pathlib import Path

import numpy as np

import swarm_envs
from docs.studies.intervals import wilson
from docs.studies.marked_page import write_between_marks
from swarm_envs.worlds import WorldSpec

PAGE = Path(__file__).with_name("index.md")
FIGURE = PAGE.with_name("shares.png")
BEHAVIOURS = ("wall following", "milling")
LABELS = ("aggregation", "cyclic pursuit", "dispersal", "milling", "wall following", "random")
COLOURS = {"wall following": "#d55e00", "milling": "#cc79a7"}
CONTROLLERS = 2000
SEEDS = (0, 1, 2)
STARTS = 5
"""Further starts of each controller that followed walls or milled."""


def worlds() -> dict[str, WorldSpec]:
    """The worlds compared: the default simulator, the calibrated one, and what lies between."""
    names = ("unrefined", "authors_2024", "hero_plus_frictionless", "hero_plus_unlimited", "hero_plus_unshielded", "hero_plus")
    found = {name: swarm_envs.load_world(name) for name in names}
    # the default simulator's contact and bodies, but speeds of the calibrated world: tells slipperiness from speed
    slow = dataclasses.replace(found["unrefined"], name="unrefined, 9 cm/s", limits=found["hero_plus"].limits)
    return {"unrefined": found.pop("unrefined"), slow.name: slow} | found


class Result:
    """What random controllers did in a world, seed by seed."""

    def __init__(self, world: WorldSpec, controllers: int, engine: str) -> None:
        self.world, self.engine = world, engine
        self.counts: list[Counter[str]] = []
        named: dict[str, list[np.ndarray]] = {name: [] for name in BEHAVIOURS}
        limits = np.array([world.limits.linear_speed, world.limits.angular_speed] * 2)
        for seed in SEEDS:
            # a seed draws the same shares of the limits in every world
            drawn = np.random.default_rng(seed).uniform(-1, 1, (controllers, 4)) * limits
            labels = self.label(drawn, seed)
            self.counts.append(Counter(labels.tolist()))
            for name in BEHAVIOURS:
                named[name].append(drawn[labels == name])
        self.whole = sum(self.counts, Counter())
        self.again = {name: self.repeat(np.concatenate(found), name) for name, found in named.items()}

    def label(self, controllers: np.ndarray, seed: int) -> np.ndarray:
        """Label a run of each controller; starts depend on the seed."""
        labels: list[str] = []
        for first in range(0, len(controllers), 500):  # 500 recorded runs are 60 MB
            part = controllers[first : first + 500]
            runs = swarm_envs.rollouts(self.world, part, seed=100_000 * seed + first, engine=self.engine)
            labels += swarm_envs.behaviours.label(runs)
        return np.array(labels)

    def repeat(self, controllers: np.ndarray, name: str) -> float:
        """Share of further starts from which controllers that had a label get it again; NaN without controllers."""
        return float(np.mean([self.label(controllers, 100 + again) == name for again in range(STARTS)])) if len(controllers) else math.nan


def describe(result: Result, name: str) -> str:
    """Three cells: a behaviour's share over all seeds with its interval, that of each seed, and how often it comes again."""
    low, high = wilson(result.whole[name], result.whole.total())
    seeds = ", ".join(f"{100 * count[name] / count.total():.2f}" for count in result.counts)
    again = "" if math.isnan(result.again[name]) else f"{100 * result.again[name]:.0f}"
    return f"{100 * result.whole[name] / result.whole.total():.2f} ({100 * low:.2f} to {100 * high:.2f}) | {seeds} | {again}"


def table(results: dict[str, Result]) -> str:
    """Markdown: the two behaviours with intervals, then every label's share."""
    lines = []
    for name in BEHAVIOURS:
        lines += [f"| world | {name}, % (95 % interval) | each seed, % | again from {STARTS} other starts, % |", "|---|---|---|---|"]
        lines += [f"| {_code(world)} | {describe(result, name)} |" for world, result in results.items()] + [""]
    lines += ["| world | " + " | ".join(f"{name}, %" for name in LABELS) + " |", "|---" * (len(LABELS) + 1) + "|"]
    for world, result in results.items():
        lines.append(
            f"| {_code(world)} | " + " | ".join(f"{100 * result.whole[name] / result.whole.total():.1f}" for name in LABELS) + " |"
        )
    return "\n".join(lines)


def draw(results: dict[str, Result], path: Path) -> None:
    """Draw shares and intervals, a row for each world."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(8, 3.8), layout="constrained")
    for row, result in enumerate(results.values()):
        whole = result.whole
        for place, name in enumerate(BEHAVIOURS):
            low, high = wilson(whole[name], whole.total())
            at, share = row + 0.16 * (2 * place - 1), whole[name] / whole.total()
            label = name if row == 0 else None
            axes.errorbar(
                100 * share,
                at,
                xerr=[[100 * (share - low)], [100 * (high - share)]],
                fmt="os"[place],
                color=COLOURS[name],
                capsize=4,
                label=label,
            )
    axes.set_yticks(range(len(results)), list(results))
    axes.invert_yaxis()
    axes.set_xlim(left=0)
    axes.set_xlabel("share of random controllers (%), with 95 % interval")
    axes.grid(axis="x", alpha=0.3)
    figure.legend(loc="outside upper right", ncols=2, frameon=False)
    figure.savefig(path, dpi=110)


def main(words: list[str] | None = None) -> None:
    """Run the study."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.wall_following_and_milling", description=__doc__)
    parser.add_argument("--engine", choices=swarm_envs.simulation.ENGINES, default="disc")
    parser.add_argument("--controllers", type=int, default=CONTROLLERS, help="a seed's random controllers")
    parser.add_argument("--print", action="store_true", help="print the tables, write nothing")
    given = parser.parse_args(words)
    results: dict[str, Result] = {}
    for name, world in worlds().items():
        results[name] = Result(world, given.controllers, given.engine)
        print(f"{name}: {dict(results[name].whole.most_common())}, again {results[name].again}", file=sys.stderr, flush=True)
    if given.print:
        print(table(results))
    else:
        draw(results, FIGURE)
        write_between_marks(PAGE, {"results": table(results)})


def _code(world: str) -> str:
    return f"`{world}`" if "," not in world else "`{}`,{}".format(*world.split(",", 1))

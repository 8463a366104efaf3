"""Figure 4 of the paper: t-SNE of each representation, as figures for paper and as a page that plays the behaviour pointed at."""

from __future__ import annotations

import dataclasses
import json
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

from discovery.evaluation.legend import COLOURS, SHAPES
from discovery.evaluation.tables import write_csv, write_figure, write_json
from discovery.files.atomic import write_atomically
from discovery.report.animation import describe_scene, pack_rollout, to_base64
from discovery.report.archive_map import lay_out
from discovery.representations.interface import embed_parts
from discovery.rollouts.labels import BEHAVIOURS
from discovery.rollouts.test_set import LabelledTestSet
from discovery.saved_run import Run
from swarm_envs.simulation import Trajectories

FRAMES = 60
"""Frames of an animation, about; 500 of eight robots make 2.4 MB of page."""


@dataclass(frozen=True)
class Map:
    """The test set as one representation sees it."""

    name: str
    seed: int
    """Of the run whose representation it is."""
    places: npt.NDArray[np.float64]
    """(N, 2), each axis from 0 to 1."""


def lay_out_maps(groups: dict[str, list[Run]], test: LabelledTestSet, iterations: int, seed: int) -> list[Map]:
    """Lay out the test set by the representation of each group's first run, the one with the smallest seed."""
    maps = []
    for name, runs in groups.items():
        run = min(runs, key=lambda each: each.settings.seed)
        maps.append(Map(name, run.settings.seed, lay_out(embed_parts(run.representation, test.parts), iterations, seed)))
    return maps


def write_maps(folder: Path, maps: list[Map], test: LabelledTestSet) -> None:
    """Write ``tsne.html``, ``tsne.csv``, ``tsne.json``, ``tsne.png`` and ``tsne.svg``."""
    rows = [
        [entry.name, entry.seed, row, name, *place]
        for entry in maps
        for row, (name, place) in enumerate(zip(test.labels.tolist(), entry.places.tolist(), strict=True))
    ]
    write_csv(folder / "tsne.csv", ["representation", "seed", "rollout", "behaviour", "x", "y"], rows, test.given_by)
    write_json(
        folder / "tsne.json",
        {
            "labels_given_by": test.given_by,
            "test_set": dict(Counter(test.labels.tolist())),
            "maps": [{"representation": entry.name, "seed": entry.seed, "places": entry.places.round(5).tolist()} for entry in maps],
        },
    )
    write_figure(draw(maps, test), folder / "tsne", test.given_by)
    write_atomically(folder / "tsne.html", page(maps, test))


def draw(maps: list[Map], test: LabelledTestSet) -> Any:
    """Return a figure with a map for each representation."""
    from matplotlib.figure import Figure

    columns = min(3, len(maps))
    rows = -(-len(maps) // columns)
    figure = Figure(figsize=(3.6 * columns, 3.5 * rows + 0.5), layout="constrained")
    axes = np.ravel(figure.subplots(rows, columns, squeeze=False))
    names = _in_order(test)
    for axis in axes[len(maps) :]:
        axis.axis("off")
    for axis, entry in zip(axes, maps, strict=False):
        for name in sorted(names, key=lambda each: each != "random"):  # the rest lies on top of random
            places = entry.places[test.labels == name]
            axis.scatter(
                *places.T, s=11, c=COLOURS.get(name, "#8a9099"), marker=SHAPES.get(name, "o"), linewidths=0, alpha=0.85, label=name
            )
        axis.set(xticks=[], yticks=[], box_aspect=1)
        axis.set_title(f"{entry.name}, seed {entry.seed}", fontsize=9)
    handles = dict(zip(*reversed(axes[0].get_legend_handles_labels()), strict=True))
    figure.legend(
        [handles[name] for name in names], names, loc="outside lower center", ncols=len(names), fontsize=8, frameon=False, markerscale=1.8
    )
    return figure


def page(maps: list[Map], test: LabelledTestSet) -> str:
    """Return one self-contained page: pointing at a rollout plays its end, on every map at once."""
    environment = Environment(
        loader=FileSystemLoader([Path(__file__).parent, Path(__file__).parents[1] / "report"]),
        autoescape=select_autoescape(["html.j2"], default=False),
        undefined=StrictUndefined,
    )
    names = _in_order(test)
    ends = [_end(part) for part in test.parts]
    every = max(1, round((len(ends[0].time) - 1) / FRAMES))
    data = {
        "scene": describe_scene(ends[0], every),
        "rollouts": [pack_rollout(part[row : row + 1], every) for part in ends for row in range(len(part))],
        "names": names,
        "labels": to_base64(np.array([names.index(name) for name in test.labels.tolist()], dtype=np.uint8)),
        "maps": [{"name": entry.name, "places": to_base64(np.round(entry.places * 32_000).astype("<i2"))} for entry in maps],
    }
    return environment.get_template("maps.html.j2").render(
        world=ends[0].world,
        maps=maps,
        counts=[(name, int((test.labels == name).sum())) for name in names],
        given_by=test.given_by,
        seconds=float(ends[0].time[-1] - ends[0].time[0]),
        data=json.dumps(data, separators=(",", ":")).replace("<", "\\u003c"),
    )


def _in_order(test: LabelledTestSet) -> list[str]:
    """Return the behaviours that occur, in the order of tables and legends."""
    return sorted(test.classes, key=lambda name: (BEHAVIOURS.index(name) if name in BEHAVIOURS else len(BEHAVIOURS), name))


def _end(part: Trajectories) -> Trajectories:
    """Return the second half of rollouts, which the encoders look at too."""
    half = slice((len(part.time) - 1) // 2, None)
    return dataclasses.replace(
        part, time=part.time[half], poses=part.poses[:, half], detections=part.detections[:, half], commands=part.commands[:, half],
        object_poses=None if part.object_poses is None else part.object_poses[:, half],
    )  # fmt: skip

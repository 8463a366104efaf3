"""Puts the report together."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

from discovery.clustering.engine_agreement import STARTS, EngineAgreement
from discovery.report.animation import describe_scene, pack_rollout, to_base64
from discovery.report.archive_map import choose_rows, lay_out
from discovery.report.chart import line_chart
from discovery.representations.interface import Fitted
from discovery.rollouts.labels import BEHAVIOURS
from discovery.rollouts.simulator import Simulator
from discovery.runs.archive import Archive
from discovery.runs.clusters import Clusters
from discovery.runs.run_folder import REPORT, RunFolder

SEARCHED = {"novelty": "Novelty search", "random": "Random sampling", "isoline": "Isoline variation"}
"""Who found the controllers, by ``search.method``."""


def write_report(
    folder: RunFolder,
    simulator: Simulator,
    archive: Archive,
    clusters: Clusters,
    agreements: list[EngineAgreement],
    fitted: Fitted,
    manifest: dict[str, Any],
) -> Path:
    """Write one self-contained HTML page and return its path."""
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent), autoescape=select_autoescape(["html.j2"], default=False), undefined=StrictUndefined
    )
    scene, cards = _cards(folder, simulator, archive, clusters, agreements)
    page = environment.get_template("page.html.j2").render(
        settings=folder.settings,
        world=simulator.world,
        manifest=manifest,
        origin=fitted.origin,
        cards=cards,
        searched=SEARCHED[folder.settings.search.method],
        starts=STARTS,
        counts=_counts(archive, clusters),
        evaluations=len(archive),
        charts=[chart for chart in (_loss_chart(fitted), _novelty_chart(archive)) if chart],
        command=_command(folder, manifest),
        shown=min(len(archive), folder.settings.report.map_points),
        data=_script_data({"scene": scene, "rollouts": [card["rollout"] for card in cards], "map": _map(folder, archive, clusters)}),
    )
    return folder.write(REPORT, page)


def _cards(
    folder: RunFolder, simulator: Simulator, archive: Archive, clusters: Clusters, agreements: list[EngineAgreement]
) -> tuple[dict[str, Any], list[dict[str, Any]]]:
    """Return what all animations share, and one card for each medoid."""
    every = folder.settings.report.frame_every
    scene: dict[str, Any] = {}
    cards: list[dict[str, Any]] = []
    for row, share, agreement in zip(clusters.medoids.tolist(), clusters.share().tolist(), agreements, strict=True):
        rollout = simulator.again(archive.controllers[row], int(archive.world_seed[row]), int(archive.world_index[row]))
        scene = describe_scene(rollout, every)
        v0, w0, v1, w1 = archive.controllers[row]
        cards.append(
            {
                "number": len(cards) + 1,
                "label": str(archive.labels[row]),
                "share": share,
                "agreement": agreement,
                "genes": [("sees nothing", 100 * v0, w0), ("sees a robot", 100 * v1, w1)],
                "generation": int(archive.generation[row]),
                "code": ", ".join(f"{gene:.4f}" for gene in archive.controllers[row]),
                "rollout": pack_rollout(rollout, every),
            }
        )
    return scene, cards


def _map(folder: RunFolder, archive: Archive, clusters: Clusters) -> dict[str, Any]:
    """Return places, labels and controllers of the archive members shown."""
    rows = choose_rows(len(archive), clusters.medoids, folder.settings.report.map_points, folder.settings.seed)
    places = lay_out(archive.embeddings[rows], folder.settings.report.map_iterations, folder.settings.seed)
    names = sorted(set(archive.labels.tolist()), key=lambda name: (BEHAVIOURS.index(name) if name in BEHAVIOURS else 99, name))
    number = {name: index for index, name in enumerate(names)}
    return {
        "count": len(rows),
        "places": to_base64(np.round(places * 32_000).astype("<i2")),
        "labels": to_base64(np.array([number[name] for name in archive.labels[rows].tolist()], dtype=np.uint8)),
        "names": names,
        "controllers": to_base64(archive.controllers[rows].astype("<f4")),
        "generations": to_base64(archive.generation[rows].astype("<i2")),
        "medoids": np.searchsorted(rows, clusters.medoids).tolist(),
    }


def _counts(archive: Archive, clusters: Clusters) -> list[dict[str, Any]]:
    """Return each behaviour's count in the archive and among the medoids."""
    everything, chosen = Counter(archive.labels.tolist()), Counter(archive.labels[clusters.medoids].tolist())
    names = list(BEHAVIOURS) + sorted(set(everything) - set(BEHAVIOURS))
    return [
        {"name": name, "archive": everything[name], "share": everything[name] / len(archive), "medoids": chosen[name]} for name in names
    ]


def _loss_chart(fitted: Fitted) -> Any:
    steps = list(range(1, len(fitted.losses) + 1))
    return line_chart(steps, fitted.losses, "Training loss", "training step", fitted.loss_name)


def _novelty_chart(archive: Archive) -> Any:
    generations = np.unique(archive.generation)
    means = [float(archive.novelty[archive.generation == generation].mean()) for generation in generations]
    return line_chart(generations.tolist(), means, "Novelty", "generation", "mean novelty (distance)")


def _command(folder: RunFolder, manifest: dict[str, Any]) -> str:
    """Return the command that repeats the run: that of its first session, without the place."""
    words = [word for word in manifest["sessions"][0]["command"] if not word.startswith(("resume=", "folder=", "runs="))]
    given = {word.split("=")[0] for word in words}
    words += [
        word
        for key, word in (("experiment", f"experiment={folder.settings.name}"), ("seed", f"seed={folder.settings.seed}"))
        if key not in given
    ]
    return " ".join(words + [f"threads={manifest['threads']}"] * ("threads" not in given))


def _script_data(data: dict[str, Any]) -> str:
    """Return JSON that can stand inside a script element."""
    return json.dumps(data, separators=(",", ":")).replace("<", "\\u003c")

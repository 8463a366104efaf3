"""The whole path, from random controllers to the report; every step takes up what the folder holds already."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import torch

from discovery.clustering.engine_agreement import EngineAgreement, compare_engines, describe
from discovery.clustering.medoids import cluster
from discovery.clustering.repeatability import most_repeatable
from discovery.clustering.wccn import within_class_covariance
from discovery.controllers import check_controllers
from discovery.errors import DiscoveryError
from discovery.export import export
from discovery.progress import stage
from discovery.report import write_report
from discovery.representations import fit
from discovery.representations.interface import Fitted
from discovery.rollouts.dataset import make_dataset
from discovery.rollouts.simulator import Simulator
from discovery.runs.archive import Archive, to_parquet
from discovery.runs.clusters import Clusters
from discovery.runs.manifest import begin_manifest, end_manifest
from discovery.runs.run_folder import ARCHIVE, ENCODER, METRICS, RunFolder
from discovery.search.search import run_search
from discovery.tracking import make_tracker
from swarm_envs.rendering import pictures
from swarm_envs.worlds import load_world

MEDOIDS = "medoids"
"""Folder in the run folder with a film and a controller update file for each medoid."""
REMADE = (ENCODER, "training/start.safetensors")
"""What learning leaves, and makes again when it is damaged."""


def discover(folder: RunFolder) -> Path:
    """Do what is left to do in a locked run folder and return the report's path.

    Raises:
        DiscoveryError: One line, when something stands in the way.
        WorldError: One line, when the world cannot be used.
    """
    settings = folder.settings
    world = load_world(settings.world)
    check_controllers(world, settings.search.include)
    manifest = begin_manifest(folder, world)
    threads = settings.threads or 1  # a run folder's settings hold a number
    torch.set_num_threads(threads)
    simulator = Simulator(world, settings.engine, settings.steps, threads)
    print(f"run        {folder.path}", flush=True)
    print(
        f"world      {world.name}: {world.num_robots} robots, {settings.steps} ticks of {world.tick:g} s, {settings.engine} engine",
        flush=True,
    )

    folder.tracker = make_tracker(folder.path, settings)
    try:
        return _stages(folder, simulator, manifest)
    finally:
        folder.tracker.close()


def _stages(folder: RunFolder, simulator: Simulator, manifest: dict[str, Any]) -> Path:
    settings, seconds = folder.settings, manifest["seconds"]
    with stage("dataset", seconds) as line:
        dataset = make_dataset(folder, simulator)
        often = f" from {settings.dataset.starts} starts each" if settings.dataset.starts > 1 else ""
        drawn = len(dataset.videos) // settings.dataset.starts
        line.done = f"{drawn} random controllers{often}, simulated and rendered as {dataset.videos.shape[1:]} videos"
    with stage("training", seconds) as line:
        for name in REMADE:
            folder.forget_damaged(name)
        fitted = fit(folder, dataset)
        line.done = fitted.done
    with stage("search", seconds) as line:
        archive, members = run_search(folder, simulator, fitted.representation)
        line.done = f"{len(archive)} controllers in the archive; {_count(archive.labels.tolist())}"
    with stage("clusters", seconds) as line:
        rows = members if settings.clustering.of == "archive" else None
        if rows is not None and len(rows) < settings.clustering.medoids:
            raise DiscoveryError(f"clustering.of: the archive holds {len(rows)} controllers, expected clustering.medoids or more of them")
        covariance = within_class_covariance(folder, simulator, fitted.representation) if settings.clustering.wccn else None
        clusters = cluster(archive.embeddings, settings.clustering, settings.seed, settings.search.distance, rows, covariance)
        repeatability = None
        if settings.clustering.repeatable:
            repeatability = most_repeatable(clusters, archive, simulator, fitted.representation, settings, covariance)
            clusters = repeatability.clusters
        folder.write(ARCHIVE, to_parquet(archive, clusters))
        medoid_labels = archive.labels[clusters.medoids].tolist()
        line.done = f"{len(clusters.medoids)} medoids; {_count(medoid_labels)}"
    with stage("agreement", seconds) as line:
        agreements = compare_engines(simulator, archive.controllers[clusters.medoids], medoid_labels, settings.seed)
        summary = summarise(settings.representation.method, archive, clusters, fitted, agreements)
        if repeatability is not None:
            summary["repeatability"] = repeatability.summary()
        folder.write_json(METRICS, summary)
        line.done = describe(agreements)
    with stage("report", seconds) as line:
        _picture(folder, simulator, archive, clusters)
        path = write_report(folder, simulator, archive, clusters, agreements, fitted, manifest)
        files = export(folder.path / MEDOIDS, simulator, archive, clusters, folder.path.name)
        line.done = f"{path.stat().st_size / 1e6:.1f} MB of HTML; {len(files) // 2} medoids as GIF and controller update file"
    folder.remove("training/*.safetensors")  # kept until now: were the encoder damaged, the last checkpoint would make it again
    end_manifest(folder, manifest)
    return path


def _picture(folder: RunFolder, simulator: Simulator, archive: Archive, clusters: Clusters) -> None:
    """Show the tracker how the medoids' rollouts end."""
    folder.tracker.begin("medoids")
    for number, row in enumerate(clusters.medoids.tolist(), start=1):
        run = simulator.again(archive.controllers[row], int(archive.world_seed[row]), int(archive.world_index[row]))
        *_, last = pictures(run, fps=1.0, speed=float(run.time[-1]))
        folder.tracker.picture("medoids", f"{number} {archive.labels[row]}", last)


def summarise(method: str, archive: Archive, clusters: Clusters, fitted: Fitted, agreements: list[EngineAgreement]) -> dict[str, Any]:
    """Return a run's numbers for ``metrics.json``."""
    medoids = clusters.medoids
    return {
        "evaluations": len(archive),
        "labels_given_by": "rules",
        "archive_labels": dict(Counter(archive.labels.tolist()).most_common()),
        "medoid_labels": dict(Counter(archive.labels[medoids].tolist()).most_common()),
        "medoids": [
            {
                "row": int(row),
                "controller": archive.controllers[row].tolist(),
                "label": str(archive.labels[row]),
                "share": float(share),
                **agreement.summary(),
            }
            for row, share, agreement in zip(medoids, clusters.share(), agreements, strict=True)
        ],
        "novelty_by_generation": [float(archive.novelty[archive.generation == g].mean()) for g in range(int(archive.generation.max()) + 1)],
        "representation": {"method": method, "origin": fitted.origin},
        "loss": fitted.losses,
    }


def _count(labels: list[str]) -> str:
    return ", ".join(f"{count} {name}" for name, count in Counter(labels).most_common())

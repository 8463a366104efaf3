"""Turns a finished discovery run into the data of the behaviour atlas: ``python -m docs.site.atlas RUN_FOLDER``.

The data are committed as atlas.json; the page's text comes from them (:mod:`docs.site.generate`), so that both speak of the same run.
"""

from __future__ import annotations

import base64
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from discovery.rollouts.labels import BEHAVIOURS
from docs.site import generate
from docs.site.atlas_data import DATA, controllers

ITERATIONS = 1000
"""Of t-SNE, which lays out the map."""


def condense(folder: Path) -> dict[str, Any]:
    """Return the atlas data of a finished run.

    Raises:
        discovery.DiscoveryError: When the folder holds no finished run.
    """
    from discovery import load_run
    from discovery.errors import DiscoveryError
    from discovery.rollouts.simulator import Simulator
    from discovery.settings import LOCATION_KEYS
    from swarm_envs.cores import available_cores
    from swarm_envs.worlds import load_world

    run = load_run(folder)
    from discovery.clustering.engine_agreement import compare_engines
    from discovery.report.archive_map import lay_out  # its libraries take seconds to import: mistakes are told before

    archive, settings, metrics = run.archive, run.settings, run.metrics
    if settings.representation.method != "simclr":
        raise DiscoveryError(f"{folder}: its representation is {settings.representation.method}; the atlas tells of an encoder, simclr")
    words = [word for word in run.manifest["sessions"][0]["command"][1:] if word.split("=")[0] not in LOCATION_KEYS]
    words += [] if any(word.startswith("threads=") for word in words) else [f"threads={run.manifest['threads']}"]
    _, first = np.unique(archive.generation, return_index=True)
    places = lay_out(archive.embeddings, ITERATIONS, settings.seed)
    simulator = Simulator(load_world(settings.world), settings.engine, settings.steps, available_cores())
    medoids = run.medoids  # asked again: runs of earlier versions do not say how often a label came back
    agreements = compare_engines(
        simulator, np.stack([each.controller for each in medoids]), [each.label for each in medoids], settings.seed
    )
    return {
        "run": {
            "name": settings.name, "world": settings.world, "engine": settings.engine, "steps": settings.steps, "seed": settings.seed,
            "evaluations": len(archive), "videos": settings.dataset.videos, "epochs": settings.representation.epochs,
            "batch": settings.representation.batch, "origin": metrics["representation"]["origin"].split(";")[0],
            "command": " ".join(["python", *words]), "commit": (run.manifest["git"] or {}).get("commit"),
            "finished": run.manifest["finished"], "handed_over": handed_over(folder),
        },
        "labels": list(BEHAVIOURS),
        "seeds": archive.world_seed[first].tolist(),
        "medoids": [
            {"row": medoid.row, "share": round(medoid.share, 4), "engines_agree": agreement.agree, "label_repeated": agreement.repeated}
            for medoid, agreement in zip(run.medoids, agreements, strict=True)
        ],
        "label": packed([BEHAVIOURS.index(label) for label in archive.labels], "u1"),
        "places": packed(np.round(places * 65_535), "<u2"),
        "generations": packed(archive.generation, "<u2"),
        "indices": packed(archive.world_index, "<u2"),
        "controllers": packed(archive.controllers, "<f8"),
    }  # fmt: skip


def handed_over(folder: Path) -> dict[str, str]:
    """Return the stages of a run that another run has made, and that run."""
    from docs.studies.discovery_of_behaviours.stage_reuse import NOTE

    note = folder / NOTE
    stages: dict[str, str] = json.loads(note.read_text(encoding="utf-8")) if note.exists() else {}
    return stages


def packed(values: npt.ArrayLike, kind: str) -> str:
    """Return numbers as base64 of little-endian bytes: exact, and a third of their digits' size."""
    return base64.b64encode(np.ascontiguousarray(values, dtype=kind).tobytes()).decode()


def main(arguments: list[str]) -> int:
    """Write atlas.json and the page; 2 for a mistake."""
    from discovery import DiscoveryError

    if len(arguments) != 1:
        print(
            "given " + (" ".join(arguments) or "nothing") + ", expected one run folder: python -m docs.site.atlas RUN_FOLDER",
            file=sys.stderr,
        )
        return 2
    try:
        data = condense(Path(arguments[0]))
    except DiscoveryError as error:
        print(error, file=sys.stderr)
        return 2
    DATA.write_text("{\n" + ",\n".join(f"{json.dumps(key)}: {json.dumps(value)}" for key, value in data.items()) + "\n}\n")
    generate.write()
    print(f"{DATA}: {len(controllers(data))} controllers, {DATA.stat().st_size / 1e3:.0f} kB; build the site with make docs")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

"""``python -m discovery.export RUN --out FOLDER``: each medoid of a finished run as a GIF and as the file that robots are loaded with."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from discovery.atomic import write_atomically
from discovery.deployment.controller_file import controller_document
from discovery.errors import DiscoveryError
from swarm_envs.worlds import WorldError

if TYPE_CHECKING:
    from discovery.saved_run import Run


def export(run: Run, out: Path, threads: int = 1) -> list[Path]:
    """Write a GIF and a controller update file for each medoid.

    Args:
        run: A finished run.
        out: The folder; made where it is missing.
        threads: Cores to use.

    Returns:
        The files' paths, two a medoid.

    Raises:
        DiscoveryError: When a file cannot be written.
        WorldError: When the run's world cannot be had any more.
    """
    from discovery.simulate import Simulator
    from swarm_envs.rendering import save_video
    from swarm_envs.worlds import load_world

    settings = run.settings
    simulator = Simulator(load_world(settings.world), settings.engine, settings.steps, threads)
    written = []
    for number, medoid in enumerate(run.medoids, start=1):
        stem = f"{number:02d}-{medoid.label.replace(' ', '-')}"
        seed, index = int(run.archive.world_seed[medoid.row]), int(run.archive.world_index[medoid.row])
        about: dict[str, str | int | float] = {
            "label": medoid.label, "labels_given_by": "rules", "world": settings.world, "run": run.path.name, "row": medoid.row,
            "share_of_archive": round(medoid.share, 4),
        }  # fmt: skip
        update, film = out / f"{stem}.yaml", out / f"{stem}.gif"
        write_atomically(update, controller_document(medoid.controller.tolist(), about))
        try:
            save_video(simulator.again(medoid.controller, seed, index), film)
        except OSError as error:
            raise DiscoveryError(f"{film}: cannot be written ({error.strerror}); make room, or choose another place with --out") from None
        written += [film, update]
    return written


def main(given: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    parser = argparse.ArgumentParser(prog="python -m discovery.export", description=__doc__)
    parser.add_argument("run", type=Path, help="folder of a finished run")
    parser.add_argument("--out", type=Path, required=True, help="folder for the files")
    parser.add_argument("--threads", type=int, default=len(os.sched_getaffinity(0)), help="cores to use (default: all)")
    arguments = parser.parse_args(given)
    try:
        from discovery.saved_run import load_run

        for path in export(load_run(arguments.run), arguments.out, arguments.threads):
            print(path)
    except (DiscoveryError, WorldError) as error:
        print(f"discovery.export: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

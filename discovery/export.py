"""``python -m discovery.export RUN --out FOLDER``: each medoid of a finished run as a GIF and as the file that robots are loaded with.

A run writes the same files into its own folder, under ``medoids``, when it ends.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from discovery.errors import DiscoveryError
from discovery.files.atomic import write_atomically
from discovery.rollouts.simulator import Simulator
from discovery.runs.archive import Archive
from discovery.runs.clusters import Clusters
from discovery.saved_run import load_run, medoids_of
from hero_robot.fleet.controller_file import controller_document
from swarm_envs.cores import available_cores
from swarm_envs.rendering import save_video
from swarm_envs.worlds import WorldError, load_world

FRAMES_PER_SECOND, WIDTH = 8.0, 240
"""Of the films: ten of them take as long as a few generations of the search, and a third of a megabyte each."""


def export(out: Path, simulator: Simulator, archive: Archive, clusters: Clusters, run: str) -> list[Path]:
    """Write a GIF and a controller update file for each medoid.

    Args:
        out: The folder; made where it is missing.
        simulator: The run's.
        archive: Has the medoids' controllers and starts.
        clusters: Say which they are.
        run: Name of the run, for people.

    Returns:
        The files' paths, two per medoid.

    Raises:
        DiscoveryError: When a file cannot be written.
    """
    written = []
    for number, medoid in enumerate(medoids_of(archive, clusters), start=1):
        about: dict[str, str | int | float] = {
            "label": medoid.label, "labels_given_by": "rules", "world": simulator.world.name, "run": run, "row": medoid.row,
            "share_of_archive": round(medoid.share, 4),
        }  # fmt: skip
        stem = f"{number:02d}-{medoid.label.replace(' ', '-')}"
        update, film = out / f"{stem}.yaml", out / f"{stem}.gif"
        write_atomically(update, controller_document(medoid.controller.tolist(), about))
        rollout = simulator.again(medoid.controller, int(archive.world_seed[medoid.row]), int(archive.world_index[medoid.row]))
        try:
            save_video(rollout, film, fps=FRAMES_PER_SECOND, width=WIDTH)
        except OSError as error:
            raise DiscoveryError(f"{film}: cannot be written ({error.strerror}); free space, or make the place writable") from None
        written += [film, update]
    return written


def main(given: Sequence[str] | None = None) -> int:
    """Run the command; returns its exit status."""
    parser = argparse.ArgumentParser(prog="python -m discovery.export", description=__doc__)
    parser.add_argument("run", type=Path, help="folder of a finished run")
    parser.add_argument("--out", type=Path, required=True, help="folder for the files")
    parser.add_argument("--threads", type=int, default=available_cores(), help="cores to use (default: all)")
    arguments = parser.parse_args(given)
    try:
        run = load_run(arguments.run)
        simulator = Simulator(load_world(run.settings.world), run.settings.engine, run.settings.steps, arguments.threads)
        for path in export(arguments.out, simulator, run.archive, run.clusters, run.path.name):
            print(path)
    except (DiscoveryError, WorldError) as error:
        print(f"discovery.export: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

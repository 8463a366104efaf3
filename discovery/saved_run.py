"""A finished run, read back."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from discovery.archive import Archive, read_parquet
from discovery.errors import DiscoveryError
from discovery.medoids import Clusters
from discovery.run_folder import ARCHIVE, ENCODER, open_folder, read_manifest
from discovery.settings import Settings

if TYPE_CHECKING:
    from discovery.representations.encoder import Encoder


@dataclass(frozen=True)
class Medoid:
    """One discovered behaviour."""

    row: int
    """Its row in the archive."""
    controller: npt.NDArray[np.float64]
    """(4,) [v0, w0, v1, w1] in m/s and rad/s."""
    label: str
    """Behaviour, given by rules."""
    share: float
    """Share of the archive in its cluster."""


@dataclass(frozen=True)
class Run:
    """What a run left behind; see :func:`load_run`."""

    path: Path
    settings: Settings
    manifest: dict[str, Any]
    archive: Archive
    clusters: Clusters

    @property
    def embeddings(self) -> npt.NDArray[np.float32]:
        """(N, d), one row for each archive member."""
        return self.archive.embeddings

    @property
    def medoids(self) -> list[Medoid]:
        """The discovered behaviours, the one with the largest cluster first."""
        rows = zip(self.clusters.medoids.tolist(), self.clusters.share().tolist(), strict=True)
        return [Medoid(row, self.archive.controllers[row], str(self.archive.labels[row]), share) for row, share in rows]

    @cached_property
    def encoder(self) -> Encoder:
        """The trained encoder: videos (n, frames, size, size) of uint8 to embeddings (n, 512).

        Raises:
            DiscoveryError: When the file is missing or damaged.
        """
        from discovery.representations.compute import choose_compute
        from discovery.representations.encoder import Encoder, load_arrays, make_network

        saved = open_folder(self.path).read_tensors(ENCODER)
        if saved is None:
            raise DiscoveryError(f"{self.path / ENCODER}: there is none; this run's representation has no encoder")
        network = make_network(saved.facts["frames"], 0)
        load_arrays(network, saved.tensors)
        settings = self.settings.representation
        compute = choose_compute("auto" if settings.device == "cuda" else settings.device, settings.precision)
        return Encoder(network, compute, settings.normalise)


def load_run(folder: str | Path) -> Run:
    """Read a finished run.

    Args:
        folder: The run folder.

    Returns:
        Archive, embeddings, encoder (read when first asked for) and medoids.

    Raises:
        DiscoveryError: When the folder holds no finished run, or a file is damaged.
    """
    path = Path(folder)
    opened = open_folder(path)
    manifest = read_manifest(path)
    if manifest is None or manifest["status"] != "finished":
        raise DiscoveryError(f"{path}: this run is not finished; finish it with python -m discovery resume={path}")
    archive, clusters = read_parquet(path / ARCHIVE)
    return Run(path, opened.settings, manifest, archive, clusters)

"""A finished run, read back."""

from __future__ import annotations

import json
import warnings
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from discovery.errors import DiscoveryError
from discovery.runs.archive import Archive, read_parquet
from discovery.runs.clusters import Clusters
from discovery.runs.run_folder import ARCHIVE, COVARIANCE, ENCODER, METRICS, open_folder, read_manifest
from discovery.settings import Settings

if TYPE_CHECKING:
    from discovery.representations.encoder import Encoder
    from discovery.representations.interface import Representation


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

    @cached_property
    def metrics(self) -> dict[str, Any]:
        """The run's numbers, ``metrics.json``."""
        found: dict[str, Any] = json.loads((self.path / METRICS).read_text(encoding="utf-8"))
        return found

    @property
    def embeddings(self) -> npt.NDArray[np.float32]:
        """(N, d), one row for each archive member."""
        return self.archive.embeddings

    @property
    def medoids(self) -> list[Medoid]:
        """The discovered behaviours, the one with the largest cluster first."""
        return medoids_of(self.archive, self.clusters)

    @cached_property
    def encoder(self) -> Encoder:
        """The trained encoder: videos (n, frames, size, size) of uint8 to embeddings (n, dimension).

        Raises:
            DiscoveryError: When the file is missing or damaged.
        """
        from discovery.representations.videos import VideoRepresentation

        found = self.representation
        if not isinstance(found, VideoRepresentation):
            raise DiscoveryError(f"{self.path / ENCODER}: there is none; this run's representation has no encoder")
        return found.encoder

    @cached_property
    def within_class_covariance(self) -> npt.NDArray[np.float64] | None:
        """Within-class covariance (d, d) that embeddings are normalised by before they are clustered, with ``clustering.wccn``.

        Raises:
            DiscoveryError: When the file is missing or damaged.
        """
        if not self.settings.clustering.wccn:
            return None
        saved = open_folder(self.path).read_tensors(COVARIANCE)
        if saved is None:
            raise DiscoveryError(f"{self.path / COVARIANCE}: there is none, though the run clustered after WCCN")
        return saved.tensors["covariance"]

    @property
    def chance_turn(self) -> npt.NDArray[np.float64] | None:
        """Matrix (d, d) of :meth:`discovery.representations.affine.AffineTransform.within_class`; the name is an earlier version's."""
        from discovery.representations.affine import AffineTransform

        warnings.warn("Run.chance_turn will go: take Run.within_class_covariance", DeprecationWarning, stacklevel=2)
        covariance = self.within_class_covariance
        return None if covariance is None else AffineTransform.within_class(np.zeros(len(covariance)), covariance).matrix

    @cached_property
    def representation(self) -> Representation:
        """What embeds rollouts as the run did.

        Raises:
            DiscoveryError: When the file is missing or damaged.
        """
        from discovery.representations import load

        return load(open_folder(self.path))


def medoids_of(archive: Archive, clusters: Clusters) -> list[Medoid]:
    """Return an archive's medoids, the one with the largest cluster first."""
    rows = zip(clusters.medoids.tolist(), clusters.share().tolist(), strict=True)
    return [Medoid(row, archive.controllers[row], str(archive.labels[row]), share) for row, share in rows]


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

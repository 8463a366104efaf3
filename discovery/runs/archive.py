"""Everything that a search evaluated, in memory and as Parquet."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import pyarrow.parquet as pq

from discovery.controllers import GENES, FloatArray
from discovery.errors import DiscoveryError
from discovery.runs.clusters import Clusters

METRICS = ("average_speed", "angular_momentum", "radial_variance", "scatter", "group_rotation")
"""Names of the five hand-crafted metrics, in order."""


@dataclass(frozen=True)
class Archive:
    """One row for each of N evaluated controllers, in the order of evaluation."""

    controllers: FloatArray
    """(N, 4) [v0, w0, v1, w1] in m/s and rad/s."""
    embeddings: npt.NDArray[np.float32]
    """(N, d)."""
    generation: npt.NDArray[np.int64]
    """(N,), 0 is the random first one."""
    novelty: FloatArray
    """(N,) novelty when the controller's generation had been evaluated; what selection saw."""
    world_seed: npt.NDArray[np.int64]
    """(N,) seed of the rollout: ``rollouts(world, controllers, seed=world_seed)`` of a whole generation repeats it."""
    world_index: npt.NDArray[np.int64]
    """(N,) place in that rollout."""
    labels: npt.NDArray[np.str_]
    """(N,) behaviour, given by rules."""
    metrics: FloatArray
    """(N, 5) hand-crafted metrics."""

    def __len__(self) -> int:
        return len(self.controllers)


def to_parquet(archive: Archive, clusters: Clusters) -> bytes:
    """Return archive and clusters as a Parquet file; the same archive gives the same bytes."""
    columns: dict[str, Any] = {gene: archive.controllers[:, index] for index, gene in enumerate(GENES)}
    columns |= {name: getattr(archive, name) for name in ("generation", "novelty", "world_seed", "world_index")}
    columns["label"] = pa.array(archive.labels.tolist()).dictionary_encode()
    columns |= {name: archive.metrics[:, index] for index, name in enumerate(METRICS)}
    columns |= {"cluster": clusters.labels, "medoid": clusters.is_medoid()}
    flat = pa.array(archive.embeddings.reshape(-1))
    columns["embedding"] = pa.FixedSizeListArray.from_arrays(flat, archive.embeddings.shape[1])
    sink = io.BytesIO()
    pq.write_table(pa.table(columns), sink, compression="zstd")
    return sink.getvalue()


def read_parquet(path: Path) -> tuple[Archive, Clusters]:
    """Read what :func:`to_parquet` wrote.

    Raises:
        DiscoveryError: When the file is missing or damaged.
    """
    try:
        table = pq.read_table(path)
        column = {name: table[name].combine_chunks() for name in table.column_names}
        values = {name: array.to_numpy(zero_copy_only=False) for name, array in column.items() if name not in ("embedding", "label")}
        embeddings = column["embedding"].flatten().to_numpy().reshape(len(table), -1)
    except (OSError, KeyError, ValueError, pa.ArrowException) as error:
        raise DiscoveryError(f"{path}: not readable ({' '.join(str(error).split())[:200]}); give the folder of a finished run") from None
    archive = Archive(
        controllers=np.stack([values[gene] for gene in GENES], axis=1),
        embeddings=embeddings,
        **{name: values[name] for name in ("generation", "novelty", "world_seed", "world_index")},
        labels=np.array(column["label"].to_pylist(), dtype=np.str_),
        metrics=np.stack([values[name] for name in METRICS], axis=1),
    )
    medoids = np.flatnonzero(values["medoid"])
    ordered = medoids[np.argsort(values["cluster"][medoids])]
    return archive, Clusters(ordered, values["cluster"])

"""pyribs' ProximityArchive without a threshold, made for 100,000 embeddings of 512 numbers."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from ribs.archives import ProximityArchive

from discovery.search.novelty import Neighbours


class UnstructuredArchive(ProximityArchive):
    """Keeps everything evaluated, duplicates too, in the order of evaluation (the paper's buffer).

    pyribs builds a k-d tree of the whole archive at every ``add``: seconds each with 100,000 embeddings, and no help in 512 dimensions.
    Here neighbours come from matrix products. And novelty is that of an archive that holds the batch already: batch-mates count, the
    point itself does not, whereas pyribs' ``add`` does not see batch-mates.

    Args:
        solution_dim: Numbers in a solution.
        measure_dim: Numbers in an embedding.
        k_neighbors: Nearest others that novelty averages over.
        distance: ``euclidean`` or ``cosine``.
        initial_capacity: Solutions to make room for.
        extra_fields: What is kept beside solution and embedding, as pyribs describes; ``novelty`` is kept anyway.
        seed: Of :meth:`sample_elites`.
    """

    def __init__(
        self,
        *,
        solution_dim: int,
        measure_dim: int,
        k_neighbors: int,
        distance: str = "euclidean",
        initial_capacity: int = 128,
        extra_fields: dict[str, Any] | None = None,
        seed: int | None = None,
    ) -> None:
        super().__init__(
            solution_dim=solution_dim,
            measure_dim=measure_dim,
            k_neighbors=k_neighbors,
            novelty_threshold=0.0,
            initial_capacity=initial_capacity,
            measures_dtype=np.float32,
            extra_fields={**(extra_fields or {}), "novelty": ((), np.float64)},
            seed=seed,
        )
        self._neighbours = Neighbours(measure_dim, distance, initial_capacity)

    def add(self, solution: npt.ArrayLike, objective: npt.ArrayLike | None, measures: npt.ArrayLike, **fields: Any) -> dict[str, Any]:
        """Add a batch.

        Args:
            solution: (B, solution_dim).
            objective: Taken for other archives' sake; here nothing is better than another thing.
            measures: (B, measure_dim).
            fields: (B, ...) each.

        Returns:
            ``status`` (B,), 2 for each as all are new, and ``novelty`` (B,).

        Raises:
            ValueError: When an embedding is not finite.
        """
        del objective
        embeddings = np.asarray(measures, dtype=np.float32)
        if not np.isfinite(embeddings).all():
            raise ValueError("measures: expected finite numbers")
        begin, count = len(self), len(embeddings)
        self._neighbours.add(embeddings)
        novelty = self._neighbours.novelty(begin, self.k_neighbors)
        self._maybe_resize(begin + count)
        data = {"solution": solution, "objective": np.zeros(count), "measures": embeddings, "novelty": novelty, **fields}
        self._store.add(np.arange(begin, begin + count), data)
        if count:
            self._stats_update(0.0, begin)
        return {"status": np.full(count, 2, dtype=np.int32), "novelty": novelty}

    def compute_novelty(self, measures: npt.ArrayLike, local_competition: npt.ArrayLike | None = None) -> npt.NDArray[np.float64]:
        """Novelty (B,) of measures (B, measure_dim) that are not in the archive; 0 when it is empty.

        Raises:
            ValueError: When local competition is asked for.
        """
        if local_competition is not None:
            raise ValueError("local_competition: this archive keeps everything, nothing competes")
        given = np.asarray(measures)
        return self._neighbours.nearest(given, self.k_neighbors)[0].mean(axis=1) if len(self) else np.zeros(len(given))

    def index_of(self, measures: npt.ArrayLike) -> npt.NDArray[np.int32]:
        """Row (B,) of the embedding nearest to each of measures (B, measure_dim).

        Raises:
            RuntimeError: When the archive is empty.
        """
        if self.empty:
            raise RuntimeError("the archive is empty; add something first")
        return self._neighbours.nearest(np.asarray(measures), 1)[1][:, 0].astype(np.int32)

    def clear(self) -> None:
        """Forget everything."""
        super().clear()
        self._neighbours = Neighbours(int(self.measure_dim), self._neighbours.distance)

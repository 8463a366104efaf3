"""Novelty: how far a behaviour is from those most like it (paper, Eq. 2)."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

SPARE = 16
"""Neighbours looked at beyond those asked for: float32 products may swap ones that are nearly as far."""
BLOCK = 2**24
"""Products held at a time (64 MB)."""


class Neighbours:
    """Embeddings that grow in number, and who is near whom.

    Candidates come from float32 matrix products, which are fast with 100,000 embeddings; their distances, and hence the order, are then
    computed one by one in float64. Cosine distance is one less the cosine of the angle at the origin.

    Args:
        dimension: Numbers in an embedding.
        distance: ``euclidean`` or ``cosine``.
        capacity: Embeddings to make room for; the room doubles when it is full.
    """

    def __init__(self, dimension: int, distance: str = "euclidean", capacity: int = 128) -> None:
        self.distance = distance
        self._vectors: npt.NDArray[np.float32] = np.empty((max(1, capacity), dimension), dtype=np.float32)
        self._halves: npt.NDArray[np.float32] = np.empty(max(1, capacity), dtype=np.float32)
        self._centre: npt.NDArray[np.float32] = np.zeros(dimension, dtype=np.float32)
        self._count = 0

    def __len__(self) -> int:
        return self._count

    def add(self, embeddings: npt.NDArray[Any]) -> None:
        """Take embeddings (B, dimension) in."""
        added = unit(embeddings) if self.distance == "cosine" else np.asarray(embeddings, dtype=np.float32)
        if self._count == 0 and len(added):
            self._centre = added.mean(axis=0)  # squares of what lies round the origin lose fewer digits
        end = self._count + len(added)
        while end > len(self._vectors):
            self._vectors = np.concatenate([self._vectors, np.empty_like(self._vectors)])
            self._halves = np.concatenate([self._halves, np.empty_like(self._halves)])
        self._vectors[self._count : end] = added
        self._halves[self._count : end] = 0.5 * np.square(added - self._centre, dtype=np.float64).sum(axis=1)
        self._count = end

    def nearest(self, queries: npt.NDArray[Any], count: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
        """Return distances and rows, each (B, count or as many as there are), of the embeddings nearest to queries (B, dimension)."""
        asked = unit(queries) if self.distance == "cosine" else np.asarray(queries, dtype=np.float32)
        count = min(count, self._count)
        at_once = max(1, BLOCK // max(1, self._count))
        found = [self._nearest(asked[start : start + at_once], count) for start in range(0, len(asked), at_once)]
        if not found:
            return np.empty((0, count)), np.empty((0, count), dtype=np.int64)
        return np.concatenate([each[0] for each in found]), np.concatenate([each[1] for each in found])

    def _nearest(self, queries: npt.NDArray[np.float32], count: int) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.int64]]:
        vectors, halves = self._vectors[: self._count], self._halves[: self._count]
        # half the squared distance, less what is the same for every row
        scores = halves - (queries - self._centre) @ vectors.T
        wanted = min(count + SPARE, self._count)
        rows = (
            np.argpartition(scores, wanted - 1, axis=1)[:, :wanted]
            if wanted < self._count
            else np.tile(np.arange(wanted), (len(queries), 1))
        )
        squares = np.stack(
            [np.square(vectors[near].astype(np.float64) - query).sum(axis=1) for near, query in zip(rows, queries, strict=True)]
        )
        distances = 0.5 * squares if self.distance == "cosine" else np.sqrt(squares)
        order = np.lexsort((rows, distances), axis=1)[:, :count]  # of equals the earlier first
        return np.take_along_axis(distances, order, axis=1), np.take_along_axis(rows, order, axis=1)

    def novelty(self, first: int, neighbours: int) -> npt.NDArray[np.float64]:
        """Mean distance of the embeddings from row ``first`` on to their nearest others: batch-mates count, the point itself does not.

        Args:
            first: The earliest row asked for.
            neighbours: How many to average over; all others when there are fewer.

        Returns:
            (B,) novelties; 0 when there is nothing else.
        """
        rows = np.arange(first, self._count)
        distances, found = self.nearest(self._vectors[first : self._count], neighbours + 1)
        # A duplicate may stand where the point itself would: then the last one goes, and it is as near as the point, at zero.
        itself = found == rows[:, None]
        itself[~itself.any(axis=1), -1:] = True
        others = distances[~itself].reshape(len(rows), -1)
        return others.mean(axis=1) if others.shape[1] else np.zeros(len(rows))


def unit(embeddings: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    """Return embeddings (N, d) at length one; those of length zero stay."""
    wide = np.asarray(embeddings, dtype=np.float64)
    lengths = np.linalg.norm(wide, axis=1, keepdims=True)
    return np.asarray(wide / np.where(lengths > 0, lengths, 1.0), dtype=np.float32)

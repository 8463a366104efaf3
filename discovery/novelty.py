"""Novelty: how far a behaviour is from those most like it (paper, Eq. 2)."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.spatial.distance import cdist


def novelty(members: npt.NDArray[Any], archive: npt.NDArray[Any], neighbours: int) -> npt.NDArray[np.float64]:
    """Mean distance of archive members to their nearest neighbours, themselves left out.

    pyribs' own ``compute_novelty`` counts an archived point as its own neighbour at distance zero, and when a batch is added it
    does not see batch-mates; here the members are in the archive already, and exactly one zero, the point itself, is dropped.

    Args:
        members: (B, d) embeddings, each of them in the archive.
        archive: (N, d) embeddings.
        neighbours: How many to average over; all others when the archive has fewer.

    Returns:
        (B,) novelties; 0 when the archive holds nothing else.
    """
    count = min(neighbours, len(archive) - 1)
    if count == 0:
        return np.zeros(len(members))
    distances = np.partition(cdist(members, archive), count, axis=1)[:, : count + 1]
    return np.asarray(np.sort(distances, axis=1)[:, 1:].mean(axis=1))

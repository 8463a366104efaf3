"""How often a representation puts rollouts of one behaviour nearer to each other than to those of another (paper, Figure 3)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from scipy.spatial.distance import cdist

FloatArray = npt.NDArray[np.float64]


def confusion(
    embeddings: npt.NDArray[np.floating], labels: npt.NDArray[np.str_], classes: Sequence[str], distance: str = "euclidean"
) -> FloatArray:
    """Return the representation confusion matrix over all valid triplets.

    A triplet is an anchor and a positive of one class and a negative of another; it is right when the positive is nearer to the
    anchor than the negative is (a tie is half right).

    Args:
        embeddings: (N, d).
        labels: (N,) the class of each.
        classes: K names, each of at least two rows.
        distance: ``euclidean`` or ``cosine``.

    Returns:
        (K, K). Off the diagonal the share of triplets with an anchor of the row's class and a negative of the column's that are
        wrong; on it the share that is right over all negatives, each class counted alike.

    Raises:
        ValueError: When there are fewer than two classes, or a class has fewer than two rows.
    """
    if len(classes) < 2:
        raise ValueError(f"given {len(classes)} classes, expected at least two: a triplet needs a negative")
    distances = cdist(embeddings, embeddings, distance)
    members = [np.flatnonzero(labels == name) for name in classes]
    for name, rows in zip(classes, members, strict=True):
        if len(rows) < 2:
            raise ValueError(f"class {name!r} has {len(rows)} rows, expected at least two: an anchor and a positive")
    matrix = np.zeros((len(classes), len(classes)))
    for i, own in enumerate(members):
        for j, others in enumerate(members):
            if i != j:
                matrix[i, j] = np.mean([_wrong(distances[a, own[own != a]], distances[a, others]) for a in own])
        matrix[i, i] = 1.0 - matrix[i, np.arange(len(classes)) != i].mean()
    return matrix


def _wrong(positives: FloatArray, negatives: FloatArray) -> float:
    """Return the share of pairs in which the positive is farther than the negative, ties by half."""
    near = np.sort(negatives)
    below, upto = np.searchsorted(near, positives, "left"), np.searchsorted(near, positives, "right")
    return float(np.mean(below + upto) / (2 * len(near)))

"""Novelty and clusters against brute force."""

import itertools

import numpy as np
import numpy.typing as npt
import pytest

from discovery.clustering.medoids import cluster
from discovery.search import novelty
from discovery.search.novelty import Neighbours
from tests.discovery.tiny_run import tiny

Array = npt.NDArray[np.float32]


def normal(*shape: int, seed: int = 0) -> Array:
    return np.random.default_rng(seed).normal(size=shape).astype(np.float32)


def brute_force(archive: Array, row: int, distance: str) -> list[float]:
    """Distances of a row to all others, the nearest first."""
    found = []
    for other in range(len(archive)):
        a, b = archive[row].astype(float), archive[other].astype(float)
        cosine = float(1 - a @ b / np.linalg.norm(a) / np.linalg.norm(b))
        if other != row:
            found.append(cosine if distance == "cosine" else float(np.sqrt(((a - b) ** 2).sum())))
    return sorted(found)


@pytest.mark.parametrize(("distance", "rounding"), [("euclidean", 1e-12), ("cosine", 1e-6)])
def test_novelty_is_the_mean_distance_to_the_nearest_others(distance: str, rounding: float) -> None:
    archive = normal(60, 7)
    archive[50] = archive[11]  # duplicates: each has a neighbour at distance zero
    near = Neighbours(7, distance)
    for start in range(0, 60, 20):
        near.add(archive[start : start + 20])
    found = near.novelty(40, 15)
    for place, row in enumerate(range(40, 60)):
        assert found[place] == pytest.approx(np.mean(brute_force(archive, row, distance)[:15]), rel=rounding, abs=rounding)


def test_novelty_sees_batch_mates_and_never_the_point_itself() -> None:
    near = Neighbours(2)
    near.add(np.array([[0.0, 0.0], [3.0, 4.0]]))
    assert np.array_equal(near.novelty(0, 1), [5.0, 5.0])
    near.add(np.zeros((20, 2)))  # more duplicates than places: the point itself may not even be among the nearest
    assert np.array_equal(near.novelty(2, 5), np.zeros(20))


def test_a_small_archive_averages_over_all_others() -> None:
    near = Neighbours(1, capacity=1)
    near.add(np.array([[0.0]]))
    assert np.array_equal(near.novelty(0, 15), [0.0])
    near.add(np.array([[1.0], [5.0]]))
    assert np.allclose(near.novelty(0, 15), [3.0, 2.5, 4.5])


def test_neighbours_of_embeddings_far_from_the_origin_are_exact_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """float32 products alone would lose these distances in the rounding of the squares."""
    monkeypatch.setattr(novelty, "BLOCK", 5000)  # in several blocks
    archive = 50 + normal(3000, 512, seed=3)
    near = Neighbours(512)
    near.add(archive)
    distances, rows = near.nearest(archive[:20], 16)
    for query in range(20):
        exact = np.linalg.norm(archive.astype(float) - archive[query], axis=1)
        assert np.array_equal(rows[query], np.argsort(exact, kind="stable")[:16])
        assert np.allclose(distances[query], np.sort(exact)[:16], rtol=1e-12)


def test_medoids_minimise_the_distance_to_their_clusters() -> None:
    points = np.random.default_rng(1).normal(size=(14, 3))
    settings = tiny("clustering.medoids=3").clustering
    clusters = cluster(points, settings, 0)

    def cost(rows: tuple[int, ...]) -> float:
        return float(np.linalg.norm(points[:, None] - points[list(rows)], axis=2).min(axis=1).sum())

    best = min(cost(rows) for rows in itertools.combinations(range(14), 3))
    assert cost(tuple(clusters.medoids)) == pytest.approx(best, rel=1e-5)
    assert np.array_equal(clusters.labels[clusters.medoids], [0, 1, 2]), "a medoid belongs to its own cluster"
    assert np.all(np.diff(clusters.share()) <= 0), "the largest comes first"
    assert clusters.share().sum() == pytest.approx(1)

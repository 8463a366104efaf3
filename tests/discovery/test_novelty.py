"""Novelty and clusters against brute force."""

import itertools

import numpy as np
import pytest

from discovery.medoids import cluster
from discovery.novelty import novelty
from tests.discovery.tiny_run import tiny


def test_novelty_is_the_mean_distance_to_the_nearest_others() -> None:
    archive = np.random.default_rng(0).normal(size=(60, 7))
    archive[10] = archive[11]  # twins: each has a neighbour at distance zero
    found = novelty(archive[5:25], archive, 15)
    for place, row in enumerate(range(5, 25)):
        others = sorted(float(np.sqrt(((archive[row] - archive[other]) ** 2).sum())) for other in range(60) if other != row)
        assert found[place] == pytest.approx(sum(others[:15]) / 15, rel=1e-12)


def test_a_small_archive_averages_over_all_others() -> None:
    archive = np.array([[0.0], [1.0], [5.0]])
    assert np.allclose(novelty(archive, archive, 15), [3.0, 2.5, 4.5])
    assert np.array_equal(novelty(archive[:1], archive[:1], 15), [0.0])


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

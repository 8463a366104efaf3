"""Clusters in the space that is asked for, of archives of any size, with members that stand for them steadily."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import numpy.typing as npt
import pytest

from discovery.clustering.embedding_space import make_space
from discovery.clustering.medoids import cluster
from discovery.clustering.repeatability import STARTS, most_repeatable
from discovery.runs.archive import Archive
from discovery.runs.clusters import Clusters
from tests.discovery.tiny_run import tiny


def blobs(each: int, seed: int = 0) -> npt.NDArray[np.float32]:
    """Four heaps on a line, in a space of five numbers; the last number is noise a thousand times as large."""
    rng = np.random.default_rng(seed)
    points = rng.normal(0, 0.05, (4 * each, 5))
    points[:, 0] += np.repeat([0, 1, 2, 3], each)
    points[:, 4] *= 1000
    return points.astype(np.float32)


def purity(clusters: Clusters, each: int) -> float:
    return float(np.mean([np.bincount(part).max() / each for part in np.split(clusters.labels, 4)]))


def test_standardised_clusters_see_small_numbers_beside_large_ones() -> None:
    points, words = blobs(50), ("clustering.medoids=4",)
    assert purity(cluster(points, tiny(*words).clustering, 0), 50) < 0.6
    assert purity(cluster(points[:, [0, 4]], tiny(*words, "clustering.standardise=true").clustering, 0), 50) > 0.6


def test_standardised_and_whitened_points_have_unit_variance() -> None:
    points = np.random.default_rng(0).normal(size=(400, 3)).astype(np.float32) @ np.array([[2, 1, 0], [0, 0.1, 5], [0, 0, 0.3]], np.float32)
    assert np.allclose(make_space(points, standardise=True).transform(points).std(axis=0), 1, atol=1e-5)
    white = make_space(points, whiten=True).transform(points)
    assert np.allclose(np.cov(white.T), np.eye(white.shape[1]), atol=0.01)
    assert white.shape[1] == 2, "the third component holds less than a hundredth of the variance"


def test_a_constant_number_harms_no_space() -> None:
    points = np.column_stack([np.ones(20), np.arange(20)]).astype(np.float32)
    for standardise, whiten in ((True, False), (False, True), (True, True)):
        assert np.isfinite(make_space(points, "euclidean", standardise, whiten).transform(points)).all()
    assert np.isfinite(make_space(points[:, :1], whiten=True).transform(points[:, :1])).all()


@pytest.mark.parametrize("distance", ["euclidean", "cosine"])
def test_distances_are_exact(distance: str) -> None:
    points = (30 + np.random.default_rng(1).normal(size=(40, 6))).astype(np.float32)
    space = make_space(points, distance)
    found = space.distances(space.transform(points), space.transform(points[:7]))
    wide = points.astype(float)
    if distance == "cosine":
        lengths = np.linalg.norm(wide, axis=1)
        expected = 1 - wide @ wide[:7].T / lengths[:, None] / lengths[:7]
    else:
        expected = np.linalg.norm(wide[:, None] - wide[:7], axis=2)
    assert np.allclose(found, expected, rtol=1e-4, atol=1e-6)


def test_cosine_clusters_compare_directions_alone() -> None:
    rng = np.random.default_rng(2)
    angles = np.repeat([0.3, 0.8, 1.3], 30) + rng.normal(0, 0.02, 90)
    points = (rng.uniform(1, 100, (90, 1)) * np.column_stack([np.cos(angles), np.sin(angles)])).astype(np.float32)
    clusters = cluster(points, tiny("clustering.medoids=3").clustering, 0, "cosine")
    assert [len(set(part)) for part in np.split(clusters.labels, 3)] == [1, 1, 1]


def test_a_large_archive_is_clustered_by_samples_as_well_as_at_once() -> None:
    points = blobs(200)[:, :4]
    points[0] = points[1]  # duplicates
    whole = cluster(points, tiny("clustering.medoids=4").clustering, 0)
    sampled = cluster(points, tiny("clustering.medoids=4", "clustering.sample=100").clustering, 0)
    assert purity(whole, 200) == purity(sampled, 200) == 1.0
    assert np.array_equal(sampled.labels[sampled.medoids], np.arange(4))

    def cost(found: Clusters) -> float:
        return float(np.linalg.norm(points - points[found.medoids][found.labels], axis=1).sum())

    assert cost(sampled) < 1.1 * cost(whole)


@pytest.mark.parametrize("sample", [10_000, 60])
def test_medoids_of_some_members_give_everything_a_cluster(sample: int) -> None:
    points = blobs(50)[:, :4]
    members = np.arange(0, 200, 2)
    found = cluster(points, tiny("clustering.medoids=4", f"clustering.sample={sample}").clustering, 0, members=members)
    assert np.isin(found.medoids, members).all()
    assert purity(found, 50) == 1.0
    assert len(found.labels) == 200


class Fickle:
    """Stands for simulator and representation: what a rollout shows is its controller, when that is steady, or chance."""

    dimension = 2

    def __call__(self, controllers: npt.NDArray[np.float64], seed: int) -> npt.NDArray[np.float64]:
        return controllers

    def embed(self, controllers: npt.NDArray[np.float64]) -> npt.NDArray[np.float32]:
        chance = np.random.default_rng(0).uniform(-5, 15, len(controllers))
        return np.column_stack([np.where(controllers[:, 1] > 0, controllers[:, 0], chance), np.zeros(len(controllers))]).astype(np.float32)


def test_the_most_repeatable_of_the_nearest_members_stands_for_its_cluster() -> None:
    heaps = np.concatenate([np.linspace(-1, 1, 11), 10 + np.linspace(-1, 1, 11)])
    steady = np.zeros(22)
    steady[[3, 6, 16]] = 1  # 6 is nearer to its medoid, 5, than 3 is; 16 is the other medoid itself
    controllers = np.column_stack([heaps, steady, heaps, heaps])
    embeddings = np.column_stack([heaps, np.zeros(22)]).astype(np.float32)
    archive = cast(Archive, SimpleNamespace(controllers=controllers, embeddings=embeddings))
    clusters = Clusters(np.array([5, 16]), np.repeat([0, 1], 11))
    fickle: Any = Fickle()
    found = most_repeatable(clusters, archive, fickle, fickle, tiny("clustering.repeatable=5"))
    assert found.clusters.medoids.tolist() == [6, 16]
    assert found.returned.tolist() == [1.0, 1.0]
    assert found.before[0] < 1.0
    assert found.rollouts == 2 * 5 * STARTS
    assert np.array_equal(found.clusters.labels, clusters.labels)
    alone = most_repeatable(clusters, archive, fickle, fickle, tiny("clustering.repeatable=1"))
    assert alone.clusters.medoids.tolist() == [5, 16]

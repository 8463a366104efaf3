"""The archive that keeps everything is pyribs' ProximityArchive in all but speed, and in what novelty counts."""

from __future__ import annotations

import numpy as np
import pytest
from ribs.archives import ProximityArchive

from discovery.search.unstructured_archive import UnstructuredArchive


def filled(distance: str = "euclidean") -> tuple[UnstructuredArchive, ProximityArchive]:
    ours = UnstructuredArchive(solution_dim=4, measure_dim=5, k_neighbors=3, distance=distance, initial_capacity=4, seed=1)
    theirs = ProximityArchive(solution_dim=4, measure_dim=5, k_neighbors=3, novelty_threshold=0.0, initial_capacity=4, seed=1)
    rng = np.random.default_rng(0)
    for count in (6, 1, 20):
        solutions, measures = rng.normal(size=(count, 4)), rng.normal(size=(count, 5)).astype(np.float32)
        ours.add(solutions, None, measures)
        theirs.add(solutions, None, measures)
    return ours, theirs


def test_it_holds_and_finds_what_pyribs_archive_does() -> None:
    ours, theirs = filled()
    queries = np.random.default_rng(2).normal(size=(9, 5)).astype(np.float32)
    assert len(ours) == len(theirs) == ours.stats.num_elites == 27
    assert np.array_equal(ours.data("solution"), theirs.data("solution"))
    assert np.allclose(ours.compute_novelty(queries), theirs.compute_novelty(queries))
    assert np.array_equal(ours.index_of(queries), theirs.index_of(queries))
    assert np.array_equal(ours.retrieve(queries)[1]["solution"], theirs.retrieve(queries)[1]["solution"])
    assert np.array_equal(ours.sample_elites(5)["solution"], theirs.sample_elites(5)["solution"])
    ours.clear()
    assert ours.empty
    assert np.array_equal(ours.compute_novelty(queries), np.zeros(9))


def test_what_is_added_gets_the_novelty_that_it_has_among_all() -> None:
    ours, _ = filled()
    added = np.ones((2, 5), np.float32)
    info = ours.add(np.zeros((2, 4)), None, added)
    assert info["status"].tolist() == [2, 2]
    assert np.array_equal(info["novelty"], ours.data("novelty")[-2:])
    others = np.sort(np.linalg.norm(ours.data("measures").astype(float) - 1, axis=1))[1:4]  # its duplicate, not itself
    assert info["novelty"] == pytest.approx([others.mean()] * 2)


def test_embeddings_that_are_no_numbers_are_refused() -> None:
    ours, _ = filled()
    with pytest.raises(ValueError, match="expected finite numbers"):
        ours.add(np.zeros((1, 4)), None, [[0, 0, 0, 0, np.nan]])
    assert len(ours) == 27

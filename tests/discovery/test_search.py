"""Searches of every kind, without simulation: an embedding is a function of the controller."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from discovery.controllers import gene_limits
from discovery.errors import DiscoveryError
from discovery.rollouts.labels import encode_labels
from discovery.search.novelty import Neighbours
from discovery.search.search import BehaviourSearch
from discovery.settings import SearchSettings
from swarm_envs.worlds import load_world
from tests.discovery.tiny_run import tiny

WORLD = load_world("hero_plus")
LIMITS = gene_limits(WORLD)
KINDS = ("novelty", "random", "cvt_random", "isoline")
SMALL = ("search.population=10", "search.generations=12")
DIMENSION = 6


def settings(kind: str, *overrides: str) -> SearchSettings:
    cells = ["search.cells=20"] if kind in ("cvt_random", "isoline") else []
    return tiny(f"search={kind}", *SMALL, *cells, *overrides).search


def pretend(controllers: npt.NDArray[np.float64]) -> dict[str, npt.NDArray[Any]]:
    """What an evaluation might find: smooth in the genes; swarms are as fast as their first gene."""
    genes = controllers / LIMITS
    return {
        "embeddings": np.concatenate([genes, np.sin(5 * genes[:, :2])], axis=1).astype(np.float32),
        "labels": encode_labels(["random"] * len(genes)),
        "metrics": np.abs(np.repeat(controllers[:, :1], 5, axis=1)),
    }


def searched(given: SearchSettings, seed: int = 0) -> BehaviourSearch:
    search = BehaviourSearch(given, WORLD, DIMENSION, seed)
    for number in range(given.generations):
        search.tell(1000 + number, pretend(search.ask()))
    return search


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_search_records_everything_in_order_and_follows_its_seed(kind: str) -> None:
    first, again, other = (searched(settings(kind), seed).archive() for seed in (3, 3, 4))
    assert len(first) == 120
    assert np.array_equal(first.generation, np.repeat(np.arange(12), 10))
    assert np.array_equal(first.world_seed, 1000 + first.generation)
    assert np.array_equal(first.embeddings, pretend(first.controllers)["embeddings"]), "rows belong together"
    assert np.array_equal(first.controllers, again.controllers)
    assert not np.array_equal(first.controllers, other.controllers)
    assert np.all(np.abs(first.controllers) <= LIMITS)


@pytest.mark.parametrize("kind", KINDS)
def test_novelty_is_recorded_as_it_was_when_the_generation_had_been_evaluated(kind: str) -> None:
    found = searched(settings(kind)).archive()
    near = Neighbours(DIMENSION)
    for generation in range(12):
        near.add(found.embeddings[found.generation == generation])
        assert np.allclose(found.novelty[found.generation == generation], near.novelty(10 * generation, 4))


def test_all_kinds_begin_with_the_same_random_controllers_and_those_given() -> None:
    given = "search.include=[[0.05,-1.0,0.0,1.0]]"
    first = [BehaviourSearch(settings(kind, given), WORLD, DIMENSION, 0).ask() for kind in KINDS]
    assert all(np.array_equal(first[0], each) for each in first[1:])
    assert first[0][0].tolist() == [0.05, -1.0, 0.0, 1.0]
    everything = searched(settings("isoline", given)).archive().controllers
    assert (everything == [0.05, -1.0, 0.0, 1.0]).all(axis=1).sum() == 1


def test_no_tree_is_built_as_the_archive_grows(monkeypatch: pytest.MonkeyPatch) -> None:
    built: list[int] = []

    def tree(points: Any, **given: Any) -> None:
        built.append(len(points))

    monkeypatch.setattr("ribs.archives._proximity_archive.KDTree", tree)
    searched(settings("novelty"))
    assert built == [0], "pyribs builds one as it begins"


def test_random_sampling_goes_on_in_the_warm_up_s_sequence() -> None:
    assert np.array_equal(searched(settings("random")).archive().controllers, searched(settings("cvt_random")).archive().controllers)


def test_isoline_variation_stays_near_its_parents_after_the_warm_up() -> None:
    found = searched(settings("isoline", "search.iso_sigma=0.001", "search.line_sigma=0")).archive()
    parents, children = found.controllers[:100] / LIMITS, found.controllers[100:] / LIMITS
    distances = np.linalg.norm(children[:, None] - parents, axis=2).min(axis=1)
    assert distances.max() < 0.01


def test_parents_come_from_the_cells_of_a_tessellation() -> None:
    """Nearly all of the warm-up is one controller, which fills one cell: it has no more children than any other cell's."""
    given = settings("isoline", "search.iso_sigma=0", "search.line_sigma=0")
    search = BehaviourSearch(given, WORLD, DIMENSION, 0)
    for number in range(given.generations):
        controllers = search.ask()
        found = pretend(controllers)
        if number < given.warmup - 3:
            found["embeddings"] = np.tile(found["embeddings"][:1] * 0, (10, 1))
        search.tell(number, found)
    crowd = search.archive().controllers[:70]
    children = search.archive().controllers[100:]
    share = (children[:, None] == crowd).all(axis=2).any(axis=1).mean()
    assert share < 0.3


def test_members_are_the_rows_that_the_archive_holds() -> None:
    everything, cells = searched(settings("novelty")), searched(settings("isoline"))
    assert np.array_equal(everything.members(), np.arange(120))
    rows = cells.members()
    assert (rows >= 100).any(), "cells keep their latest"
    assert 10 < len(rows) <= 20, "one for each cell that is not empty"
    assert (rows < 100).any()
    assert np.array_equal(rows, np.unique(rows))


@pytest.mark.parametrize("kind", KINDS)
def test_slow_and_straight_controllers_are_never_evaluated(kind: str) -> None:
    found = searched(settings(kind, "search.min_speed=0.05", "search.min_turn_rate=0.4")).archive()
    assert len(found) == 120, "the budget counts what is evaluated"
    assert np.all(np.abs(found.controllers) >= [0.05, 0.4, 0.05, 0.4])
    assert len(np.unique(found.controllers, axis=0)) > 60


def test_what_may_be_drawn_is_drawn_uniformly() -> None:
    given = settings("random", "search.min_speed=0.05", "search.min_turn_rate=0.4", "search.population=4000", "search.generations=1")
    drawn = BehaviourSearch(given, WORLD, DIMENSION, 0).ask()
    for gene, (least, limit) in enumerate(zip([0.05, 0.4] * 2, LIMITS, strict=True)):
        magnitude = (np.abs(drawn[:, gene]) - least) / (limit - least)
        assert np.histogram(magnitude, 4, (0, 1))[0] == pytest.approx(1000, abs=120)
        assert np.mean(drawn[:, gene] > 0) == pytest.approx(0.5, abs=0.03)


def test_only_what_meets_the_minimal_criterion_has_children() -> None:
    given = settings("novelty", "search.minimal_criterion=0.5", "search.mutation=0", "search.crossover=0", "search.population=50")
    search = BehaviourSearch(given, WORLD, DIMENSION, 0)
    parents = search.ask()
    search.tell(0, pretend(parents))
    children = search.ask()
    assert len(children) == 50
    assert np.abs(children[:, 0]).min() >= 0.5 * LIMITS[0] > np.abs(parents[:, 0]).min()


@pytest.mark.parametrize(
    ("kind", "overrides", "expected"),
    [
        ("novelty", ["search.min_speed=0.09"], r"search.min_speed: given 0.09, expected less than 0.09 m/s, the limit of world hero_plus"),
        ("novelty", ["search.min_turn_rate=2"], r"search.min_turn_rate: given 2"),
        ("novelty", ["search.min_speed=0.05", "search.include=[[0.01,1,0.06,1]]"], r"search.include: given \[0.01, "),
        ("novelty", ["search.archive=cvt"], r"search.archive: given 'cvt'"),
        ("isoline", ["search.warmup=0", "search.archive=proximity"], r"search.warmup: given 0, expected 1 or more"),
        ("isoline", ["search.cells=101"], r"search.cells: given 101, expected at most the 100 evaluations"),
        ("isoline", ["search.distance=cosine"], r"search.distance: given 'cosine'"),
        ("random", ["search.warmup=12"], r"search.warmup: given 12, expected fewer than search.generations"),
        ("random", ["search.minimal_criterion=0.1"], r"search.minimal_criterion"),
        ("novelty", ["search.distance=manhattan"], r"search.distance: given 'manhattan', expected euclidean or cosine"),
    ],
)
def test_settings_that_contradict_each_other_are_refused(kind: str, overrides: list[str], expected: str) -> None:
    with pytest.raises(DiscoveryError, match=expected):
        BehaviourSearch(settings(kind, *overrides), WORLD, DIMENSION, 0)

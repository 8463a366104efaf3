"""Clusters after within-class covariance normalisation: in units of how rollouts of one controller differ from start to start."""

import dataclasses
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from discovery import load_run
from discovery.clustering.medoids import cluster
from discovery.clustering.wccn import covariance_within_groups
from discovery.command import RunContext, run
from discovery.errors import DiscoveryError
from discovery.evaluation.frequency import random_searches, standardised_medoids
from discovery.representations.affine import SHRINKAGE, AffineTransform
from discovery.rollouts.dataset import make_dataset, rollouts_again
from discovery.rollouts.simulator import Simulator
from discovery.runs.run_folder import ARCHIVE, COVARIANCE, ENCODER, METRICS, open_folder
from swarm_envs.metrics import hand_crafted
from swarm_envs.worlds import load_world
from tests.discovery.stopping import run_until
from tests.discovery.tiny_run import tiny

pytestmark = pytest.mark.slow

WORDS = ("dataset.starts=2", "clustering.wccn=true", "representation=hand_crafted", "clustering.medoids=4", "search.generations=4")


def with_wccn(*words: str) -> tuple[str, ...]:
    return (*WORDS, *words)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("chance") / "run"
    run(tiny(*with_wccn(f"folder={path}"), simclr=False), given=True, context=RunContext())
    return path


@pytest.mark.parametrize("starts", [2, 3, 7])
def test_the_covariance_within_groups_is_found_whatever_the_groups_are(starts: int) -> None:
    rng = np.random.default_rng(0)
    mix = np.array([[2.0, 0.0, 0.0], [1.0, 0.5, 0.0], [0.0, 0.3, 0.1]])
    away = rng.normal(size=(4000, starts, 3)) @ mix
    rows = (away + 100 * rng.normal(size=(4000, 1, 3))).reshape(-1, 3)
    np.testing.assert_allclose(covariance_within_groups(rows, starts), mix.T @ mix, atol=0.25)


def test_in_its_units_a_covariance_is_nearly_one_and_a_direction_without_chance_is_not_blown_up_without_bound() -> None:
    covariance = np.diag([100.0, 4.0, 0.0])
    turn = AffineTransform.within_class(np.zeros(3), covariance).matrix
    np.testing.assert_allclose(np.diag(turn.T @ covariance @ turn), [100 / 93.5, 4 / 7.1, 0], rtol=0.03)
    assert turn[2, 2] == pytest.approx(1 / np.sqrt(SHRINKAGE * 104 / 3))
    np.testing.assert_array_equal(AffineTransform.within_class(np.zeros(2), np.zeros((2, 2))).matrix, np.eye(2))


def test_heaps_that_chance_smears_along_one_direction_are_told_apart_only_in_units_of_chance() -> None:
    rng = np.random.default_rng(1)

    def draw(heap: npt.NDArray[np.int64]) -> npt.NDArray[np.float32]:
        return np.column_stack([2 * heap + rng.normal(0, 0.1, len(heap)), rng.normal(0, 3, len(heap))]).astype(np.float32)

    heaps = np.repeat(np.arange(3), 60)
    points, dataset = draw(heaps), draw(np.repeat(rng.integers(0, 3, 200), 2))
    covariance = covariance_within_groups(dataset.astype(float), 2)
    words = ("clustering.medoids=3", "dataset.starts=2")
    normalised = tiny(*words, "clustering.wccn=true").clustering
    plain, found = cluster(points, tiny(*words).clustering, 0), cluster(points, normalised, 0, covariance=covariance)
    purity = [np.mean([np.bincount(part).max() / 60 for part in np.split(each.labels, 3)]) for each in (plain, found)]
    assert purity[0] < 0.75
    assert purity[1] > 0.9


def test_the_rollouts_measured_are_those_of_the_dataset_again(made: Path) -> None:
    folder, simulator = open_folder(made), Simulator(load_world("hero_plus"), "chipmunk", 40, 1)
    again = np.concatenate([hand_crafted(part) for part in rollouts_again(folder, simulator)])
    np.testing.assert_array_equal(again, make_dataset(folder, simulator).metrics)
    saved = folder.read_tensors(COVARIANCE)
    assert saved is not None
    np.testing.assert_allclose(saved.tensors["covariance"], covariance_within_groups(again.astype(np.float32).astype(float), 2))


def test_a_run_read_back_has_the_covariance_that_its_medoids_were_chosen_with(made: Path) -> None:
    found = load_run(made)
    assert found.within_class_covariance is not None
    clusters = cluster(found.embeddings, found.settings.clustering, found.settings.seed, covariance=found.within_class_covariance)
    np.testing.assert_array_equal(clusters.medoids, found.clusters.medoids)
    assert len(standardised_medoids("", [found]).labels[0]) == 4
    (sampled,) = random_searches({"": [found]}, Simulator(load_world("hero_plus"), "chipmunk", 40, 1))
    assert len(sampled.labels[0]) == 4


def test_the_earlier_name_of_a_runs_covariance_gives_the_matrix_and_warns(made: Path) -> None:
    found = load_run(made)
    with pytest.warns(DeprecationWarning, match=r"take Run\.within_class_covariance"):
        matrix = found.chance_turn
    assert matrix is not None
    covariance = found.within_class_covariance
    assert covariance is not None
    shrunk = 0.9 * covariance + 0.1 * np.trace(covariance) / len(covariance) * np.eye(len(covariance))
    np.testing.assert_allclose(matrix @ shrunk @ matrix, np.eye(len(covariance)), atol=1e-6)


def test_a_run_stopped_before_its_covariance_was_saved_ends_with_the_same_bits(
    made: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "stopped"
    run_until(COVARIANCE, tiny(*with_wccn(f"folder={path}"), simclr=False), monkeypatch)
    (path / COVARIANCE).write_bytes(b"damaged")
    run(tiny(*with_wccn(f"resume={path}"), simclr=False), given=False, context=RunContext())
    for name in (ARCHIVE, METRICS, COVARIANCE):
        assert (path / name).read_bytes() == (made / name).read_bytes(), name
    (path / COVARIANCE).unlink()
    with pytest.raises(DiscoveryError, match="clustered after WCCN"):
        _ = load_run(path).within_class_covariance


def test_wccn_goes_with_repeatable_medoids_of_a_tessellations_cells(tmp_path: Path) -> None:
    words = ("search=cvt_random", "search.warmup=2", "search.cells=10", "clustering.of=archive", "clustering.repeatable=2")
    run(tiny(*with_wccn(*words, f"folder={tmp_path / 'run'}"), simclr=False), given=True, context=RunContext())
    found = load_run(tmp_path / "run")
    assert len(found.medoids) == 4
    assert len(found.metrics["repeatability"]["returned"]) == 4
    assert "Random sampling evaluated" in (tmp_path / "run" / "report.html").read_text(encoding="utf-8")


def test_a_run_on_pairs_of_two_starts_that_was_stopped_makes_encoder_and_units_again_when_they_are_damaged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    words, path = ("dataset.starts=2", "clustering.wccn=true", "clustering.medoids=4"), tmp_path / "stopped"
    run(tiny(*words, f"folder={tmp_path / 'whole'}"), given=True, context=RunContext())
    run_until("training/step-0000003", tiny(*words, f"folder={path}"), monkeypatch)
    run_until(ARCHIVE, tiny(*words, f"resume={path}"), monkeypatch)
    (path / ENCODER).write_bytes(b"damaged")
    with open_folder(path) as folder:
        folder.write_tensors(COVARIANCE, {"covariance": np.eye(512)}, {"starts": 2})
    run(tiny(*words, f"resume={path}"), given=False, context=RunContext())
    for name in (ARCHIVE, ENCODER, COVARIANCE):
        assert (path / name).read_bytes() == (tmp_path / "whole" / name).read_bytes(), name


def test_clusters_in_units_of_chance_are_never_made_without_them_nor_others_with_them() -> None:
    points, settings = np.random.default_rng(0).normal(size=(20, 2)), tiny(*WORDS, simclr=False).clustering
    for asked, covariance in ((True, None), (False, np.eye(2))):
        with pytest.raises(ValueError, match=r"clustering\.wccn is"):
            cluster(points, dataclasses.replace(settings, wccn=asked), 0, covariance=covariance)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("representation=random", "representation.metrics_square_root=true"), "representation.metrics_square_root: given true, but"),
        (
            ("clustering.wccn=true", "representation=hand_crafted"),
            "clustering.wccn: needs dataset.starts of 2 or more, given 1",
        ),
        (with_wccn("clustering.whiten=true"), "clustering.wccn: given together with clustering.whiten"),
        (with_wccn("clustering.standardise=true"), "clustering.wccn: given together with clustering.standardise"),
    ],
)
def test_units_that_cannot_be_had_are_refused_in_one_line(words: tuple[str, ...], message: str) -> None:
    with pytest.raises(DiscoveryError, match=message):
        tiny(*words, simclr=False)

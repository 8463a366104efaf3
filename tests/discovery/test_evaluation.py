"""Evaluation of representations and searches: numbers against their definitions, and the commands as a user calls them."""

from __future__ import annotations

import csv
import itertools
import json
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest

from discovery.command import RunContext, run
from discovery.evaluation.command import main
from discovery.evaluation.frequency import Found
from discovery.evaluation.groups import group, mean_and_error, representation_name
from discovery.evaluation.probes import probe
from discovery.evaluation.triplets import confusion
from discovery.rollouts.simulator import Simulator
from discovery.rollouts.test_set import draw_test_set, shares
from discovery.saved_run import Run
from swarm_envs.behaviours import label
from swarm_envs.worlds import load_world
from tests.discovery.tiny_run import tiny

pytestmark = pytest.mark.slow

CLASSES = ["a", "b", "c"]


def clouds(distance: float, each: int = 12) -> tuple[np.ndarray, np.ndarray]:
    generator = np.random.default_rng(0)
    labels = np.repeat(CLASSES, each)
    centres = distance * np.eye(3)[np.repeat(np.arange(3), each)]
    return centres + generator.normal(size=(3 * each, 3)), labels


def test_the_confusion_matrix_equals_counting_every_triplet() -> None:
    points, labels = clouds(1.0, 7)
    found = confusion(points, labels, CLASSES)
    for i, j in itertools.permutations(range(3), 2):
        own, others = np.flatnonzero(labels == CLASSES[i]), np.flatnonzero(labels == CLASSES[j])
        wrong = [
            np.linalg.norm(points[a] - points[p]) > np.linalg.norm(points[a] - points[n])
            for a, p in itertools.permutations(own, 2) for n in others
        ]  # fmt: skip
        assert found[i, j] == pytest.approx(np.mean(wrong), abs=1e-12)
        assert found[i, i] == pytest.approx(1 - (found[i, (i + 1) % 3] + found[i, (i + 2) % 3]) / 2, abs=1e-12)


def test_a_representation_that_tells_nothing_is_half_right_and_a_perfect_one_is_right() -> None:
    points, labels = clouds(1.0)
    np.testing.assert_allclose(confusion(np.zeros_like(points), labels, CLASSES), 0.5)
    np.testing.assert_allclose(confusion(np.eye(3)[np.repeat(np.arange(3), 12)], labels, CLASSES), np.eye(3))
    many = clouds(0.0, 60)
    np.testing.assert_allclose(np.diag(confusion(*many, CLASSES)), 0.5, atol=0.05)


def test_the_distance_is_that_which_the_search_went_by() -> None:
    points = np.array([[1.0, 0.0], [9.0, 0.1], [0.0, 2.0], [0.1, 9.0]])
    labels = np.array(["a", "a", "b", "b"])
    np.testing.assert_allclose(np.diag(confusion(points, labels, ["a", "b"], "cosine")), 1.0)
    assert confusion(points, labels, ["a", "b"])[0, 0] < 1.0


def test_test_sets_hold_what_is_wanted_of_each_class_and_more_of_some_where_others_are_rare() -> None:
    assert shares(dict.fromkeys("abcde", 250), 100) == dict.fromkeys("abcde", 100)
    assert shares(dict.fromkeys("abcdef", 250), 100) == dict.fromkeys("abcdef", 100)
    four = shares({"a": 250, "b": 250, "c": 250, "d": 250, "rare": 21}, 100)
    assert (sum(four.values()), four["rare"], max(four.values()), min(four[name] for name in "abcd")) == (500, 21, 120, 119)
    assert shares({"a": 250, "b": 110}, 100) == {"a": 250, "b": 110}, "all that there are"


def test_a_test_set_is_as_large_as_asked_and_its_rollouts_have_their_labels() -> None:
    test = draw_test_set(Simulator(load_world("hero_plus"), "disc", 200, 1), 10, 250, 0)
    assert len(test.labels) == 50
    assert [name for part in test.parts for name in label(part)] == test.labels.tolist()


def test_runs_that_differ_in_more_than_the_seed_are_told_apart() -> None:
    class Given:
        def __init__(self, *words: str) -> None:
            self.settings = tiny(*words)

    runs = [Given("seed=0"), Given("seed=1", "folder=here", "name=x"), Given("seed=0", "search.crossover=0.5")]
    groups = group(runs[:2], lambda run: "same")  # type: ignore[arg-type]
    assert {name: len(members) for name, members in groups.items()} == {"same": 2}
    groups = group(runs, lambda run: "same")  # type: ignore[arg-type]
    assert {name: len(members) for name, members in groups.items()} == {
        "same; search.crossover=0.7": 2, "same; search.crossover=0.5": 1,
    }  # fmt: skip


def test_a_class_of_one_is_refused() -> None:
    with pytest.raises(ValueError, match="class 'b' has 1 rows, expected at least two"):
        confusion(np.zeros((3, 2)), np.array(["a", "a", "b"]), ["a", "b"])


def test_probes_read_what_is_there_and_nothing_where_nothing_is() -> None:
    apart, chance = probe(*clouds(20.0)), probe(*clouds(0.0, 60))
    assert min(apart.values()) == 1.0
    assert max(chance.values()) < 0.5, "a third is chance"


def test_means_have_standard_errors_over_runs_and_one_run_has_none() -> None:
    mean, error = mean_and_error([1.0, 2.0, 3.0])
    assert (float(mean), float(error)) == pytest.approx((2.0, 1 / np.sqrt(3)))
    assert np.isnan(mean_and_error([4.0])[1])


def test_random_is_no_unique_behaviour() -> None:
    assert Found("x", [["random"] * 10, ["random", "milling", "milling", "dispersal"]]).unique == [0, 2]


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Two seeds of the raw metrics and one random encoder."""
    folder, paths = tmp_path_factory.mktemp("evaluated"), []
    for name, seed in (("hand_crafted", 0), ("hand_crafted", 1), ("random", 0)):
        paths.append(str(folder / f"{name}-{seed}"))
        run(
            tiny("steps=600", f"representation={name}", f"seed={seed}", f"folder={paths[-1]}", simclr=False),
            given=True,
            context=RunContext(),
        )
    return paths


def test_the_command_compares_representations_over_their_runs(runs: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["representations", *runs, "--out", str(tmp_path), "--per-class", "20", "--most-draws", "500", "--threads", "1"]) == 0
    said = capsys.readouterr().out
    found = json.loads((tmp_path / "representations.json").read_text())
    entries = {entry["name"]: entry for entry in found["representations"]}
    assert found["labels_given_by"] == "rules"
    assert set(entries) == {"hand-crafted", "random ResNet18"}
    assert entries["hand-crafted"]["runs"] == 2
    assert entries["hand-crafted"]["triplet_accuracy"][1] == 0.0, "raw metrics are the same whatever the seed"
    assert entries["random ResNet18"]["triplet_accuracy"][1] is None
    assert 0.5 < entries["hand-crafted"]["triplet_accuracy"][0] < 1.0
    assert "hand-crafted: triplets" in said
    rows = list(csv.DictReader((tmp_path / "representations.csv").read_text().splitlines()))
    assert len(rows) == 2 * len(found["classes"]) ** 2
    for ending in ("png", "svg"):
        assert (tmp_path / f"representations.{ending}").stat().st_size > 5000


def test_the_command_counts_behaviours_among_medoids_and_by_simpler_ways(runs: list[str], tmp_path: Path) -> None:
    assert main(["behaviours", *runs, "--out", str(tmp_path), "--threads", "1"]) == 0
    found = json.loads((tmp_path / "behaviours.json").read_text())
    assert len(found["medoids"]) == 6
    for name, medoids in found["medoids"].items():
        assert len(medoids) == (2 if name.startswith("hand") else 1)
        assert all(sum(counts.values()) == 10 for counts in medoids)
    row = next(row for row in found["rows"] if row["way"] == "hand-crafted" and row["behaviour"] == "random")
    assert row["mean"] == np.mean([counts.get("random", 0) for counts in found["medoids"]["hand-crafted"]])
    assert row["paper_mean"] == 5.0
    medoids = found["medoids"]["hand-crafted"]
    assert found["ways"]["hand-crafted"]["unique_each_run"] == [len(set(counts) - {"random"}) for counts in medoids]
    assert "hand-crafted" in found["fewer_runs_than_wanted"], "two are given, five are wanted"
    rows = list(csv.DictReader((tmp_path / "behaviours.csv").read_text().splitlines()))
    assert {row["labels given by"] for row in rows} == {"rules"}
    assert next(row for row in rows if row["way"] == "random ResNet18")["paper's mean"] == "nan"


def test_runs_of_different_worlds_are_not_compared(runs: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    other = str(tmp_path / "other")
    run(tiny("world=unrefined", "representation=hand_crafted", f"folder={other}", simclr=False), given=True, context=RunContext())
    capsys.readouterr()  # a run that takes long has shown its progress
    assert main(["behaviours", runs[0], other, "--out", str(tmp_path / "out")]) == 1
    assert capsys.readouterr().err == (
        "discovery.evaluation: the runs differ in world, engine or steps; evaluate those of one world together\n"
    )
    assert not (tmp_path / "out").exists()


def test_a_folder_without_a_run_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["behaviours", str(tmp_path), "--out", str(tmp_path / "out")]) == 1
    said = capsys.readouterr().err
    assert len(said.splitlines()) == 1
    assert said.startswith("discovery.evaluation: ")
    assert str(tmp_path) in said


def test_a_representation_that_somebody_adds_goes_by_its_method() -> None:
    settings = SimpleNamespace(representation=SimpleNamespace(method="spacing", bins=16), dataset=SimpleNamespace(starts=2))
    assert representation_name(cast(Run, SimpleNamespace(settings=settings))) == "spacing"

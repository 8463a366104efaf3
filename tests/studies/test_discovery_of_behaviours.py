"""The study: its plan, what runs hand to one another, going on where it was stopped, and the page."""

from __future__ import annotations

import dataclasses
import json
import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from hydra import compose, initialize_config_dir

import discovery
from discovery.annotation.answers import open_answers
from discovery.clustering.repeatability import STARTS
from discovery.command import CONFIGS, RunContext, run
from discovery.errors import DiscoveryError
from discovery.evaluation.frequency import Found
from discovery.evaluation.groups import ASIDE, PERSONAL
from discovery.runs.run_folder import make_folder, open_folder
from discovery.settings import flat, read_settings, to_yaml
from docs.studies.discovery_of_behaviours.command import PLAN as STUDY
from docs.studies.discovery_of_behaviours.command import main
from docs.studies.discovery_of_behaviours.evaluating import Evaluations
from docs.studies.discovery_of_behaviours.page import EMPTY, write_page
from docs.studies.discovery_of_behaviours.plan import Plan, Planned, choose, plan_runs, read_plan
from docs.studies.discovery_of_behaviours.running import check_folders, finished, run_all
from docs.studies.discovery_of_behaviours.stage_reuse import NOTE, reuse_stages
from docs.studies.discovery_of_behaviours.variants import Variant
from docs.studies.discovery_of_behaviours.weights import without_weights
from tests.discovery.tiny_run import SHORT, SIMCLR

BRIEF = [*SIMCLR, "representation.epochs=1", "representation.checkpoint_seconds=60"]
TINY = [word for word in SHORT if not word.startswith(("steps", "threads"))]
PLAN = f"""
all: {{quick: [{", ".join(TINY)}, steps=100], paper: [experiment=paper]}}
target: hero_plus
worlds: [unrefined]
worlds_with: simclr
starts: 3
test_set: {{per_class: 12, most_draws: 250}}
representations:
  hand_crafted: [representation=hand_crafted]
  simclr: {{quick: [{", ".join(BRIEF)}], paper: [representation=simclr]}}
variants:
  - name: cosine
    tries: cosine distance
    overrides: [search.distance=cosine]
  - name: other_length
    tries: the other length
    overrides: {{quick: [representation.normalise=false], paper: []}}
  - name: six
    tries: six medoids
    overrides: [clustering.medoids=6]
"""


class Runs:
    """Finishes runs in this process, and remembers which."""

    def __init__(self, fail: str = "") -> None:
        self.made: list[str] = []
        self.fail = fail

    def __call__(self, each: Planned) -> None:
        name = f"{each.entry.name}-{each.seed}"
        if name == self.fail:
            raise DiscoveryError("ended with status 1")
        self.made.append(name)
        settings = open_folder(each.path).settings
        settings.resume = str(each.path)
        run(settings, given=False, context=RunContext())


class Study:
    """A plan of tiny runs, with a folder."""

    def __init__(self, folder: Path) -> None:
        self.file, self.out = folder / "plan.yaml", folder / "out"
        folder.mkdir(exist_ok=True)
        self.file.write_text(PLAN)
        self.plan: Plan = read_plan(self.file, "quick")
        self.everything = plan_runs(self.plan, self.plan.entries, 2, self.out, 1)

    def run(self, runs: Runs, names: Sequence[str] | None = None, seeds: int = 2) -> list[str]:
        chosen = {entry.name for entry in choose(self.plan, names)}
        return run_all([each for each in self.everything if each.entry.name in chosen and each.seed < seeds], self.everything, runs)

    def path(self, kind: str, name: str, seed: int) -> Path:
        return self.out / kind / name / f"seed-{seed}"


@pytest.fixture(scope="module")
def study(tmp_path_factory: pytest.TempPathFactory) -> Study:
    """One seed of everything, two of what the first figures are of."""
    made = Study(tmp_path_factory.mktemp("study") / "a")
    assert made.run(Runs(), seeds=1) == []
    assert made.run(Runs(), ["hand_crafted", "simclr"]) == []
    return made


def test_the_projects_own_plan_is_made_of_settings_that_there_are() -> None:
    plan = read_plan(STUDY, "quick")
    runs = plan_runs(plan, plan.entries, 5, Path("out"), 2)
    assert len(runs) == 5 * len(plan.entries)
    for each in runs:  # the paper's budget, and it is said where more is spent
        search, clustering = each.settings.search, each.settings.clustering
        spent = search.population * search.generations + clustering.medoids * clustering.repeatable * STARTS
        assert spent == 5000 or (spent == 5300 and "300 runs beyond the budget" in each.entry.tries), each.entry.name
    assert {each.settings.clustering.medoids for each in runs} == {10}
    first = [each for each in runs if each.seed == 0]
    assert {each.entry.name: each.settings.representation.method for each in first if each.entry.kind == "representations"} == {
        "hand_crafted": "hand_crafted", "hand_crafted_standardised": "hand_crafted", "hand_crafted_roots": "hand_crafted",
        "triplet_simulated_annotator": "triplet",
        "simclr": "simclr", "simclr_starts": "simclr", "random": "untrained", "imagenet": "untrained",
    }  # fmt: skip
    assert {each.settings.world for each in first if each.entry.kind == "worlds"} == {
        "unrefined", "hero_plus_frictionless", "hero_plus_unlimited", "hero_plus_unshielded",
    }  # fmt: skip
    settings = [to_yaml(each.settings) for each in first if each.entry.name != "hand_crafted"]
    assert len(set(settings)) == len(settings), "no two entries are the same"


def test_the_best_experiment_is_the_studys_entry_that_met_every_goal() -> None:
    plan = read_plan(STUDY, "quick")
    (entry,) = plan_runs(plan, choose(plan, ["starts_roots_by_chance"]), 1, Path("out"), 2)
    with initialize_config_dir(str(CONFIGS), version_base="1.3"):
        best = flat(read_settings(compose("config", ["experiment=best"])))
    same = {key: value for key, value in flat(entry.settings).items() if key not in PERSONAL and not key.startswith(ASIDE)}
    assert same == {key: best[key] for key in same}


@pytest.mark.parametrize(("size", "numbers"), [("quick", (1500, 10, 100)), ("paper", (6000, 100, 1000))])
def test_the_size_decides_on_training_alone(size: str, numbers: tuple[int, int, int]) -> None:
    plan = read_plan(STUDY, size)
    for each in plan_runs(plan, choose(plan, ["simclr", "unrefined"]), 1, Path("out"), 2):
        settings = each.settings
        assert (settings.dataset.videos, settings.representation.epochs, settings.representation.batch) == numbers
        assert (settings.search.population, settings.search.generations, settings.search.neighbours) == (50, 100, 15)


def test_a_mistake_in_the_plan_is_one_line_before_anything_runs(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "plan.yaml"
    for text, told in (
        (PLAN.replace("search.distance=cosine", "search.distanz=cosine"), "variants, cosine: "),
        (PLAN.replace("search.distance=cosine", "search.distance=far"), "variants, cosine: search.distance: given 'far'"),
        (PLAN.replace("name: six", "name: cosine"), "cosine named twice"),
        (PLAN.replace("name: six", "name: six/seven"), "it names a folder"),
        (PLAN.replace("worlds_with: simclr", "worlds_with: nobody"), "not a plan"),
        (PLAN.replace("overrides: [clustering.medoids=6]", "overrides: clustering.medoids=6"), "expected a list of settings"),
        (PLAN.replace("name: six", "on: simclr\n    name: six"), "variant 'six' says 'True', expected name, overrides"),  # YAML's on
        (PLAN.replace("starts: 3\n", ""), "expected the keys all, representations, starts"),
        ("- [", "not readable"),
    ):
        file.write_text(text)
        assert main(["--plan", str(file), "--out", str(tmp_path / "out"), "--threads", "1"]) == 1
        said = capsys.readouterr().err
        assert len(said.splitlines()) == 1
        assert told in said
    file.write_text(PLAN)
    assert main(["--plan", str(file), "--only", "nothing", "--out", str(tmp_path / "out"), "--threads", "1"]) == 1
    assert "no entry is named 'nothing'; there are representations, worlds, variants, hand_crafted" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_entries_are_chosen_by_name_and_by_kind_in_the_plans_order(study: Study) -> None:
    def chosen(*names: str) -> list[str]:
        return [entry.name for entry in choose(study.plan, names or None)]

    assert chosen() == ["hand_crafted", "simclr", "unrefined", "cosine", "other_length", "six"]
    assert chosen("six", "representations") == ["hand_crafted", "simclr", "six"]
    assert chosen("worlds") == ["unrefined"]


def test_every_run_is_an_ordinary_run_folder(study: Study) -> None:
    for each in study.everything:
        if each.seed == 0:
            found = discovery.load_run(each.path)
            assert len(found.archive) == 24
            assert (each.path / "report.html").exists()
            assert [medoid.label for medoid in found.medoids] == found.archive.labels[found.clusters.medoids].tolist()


def test_what_runs_share_is_made_once_and_the_result_is_as_if_made_anew(study: Study, tmp_path: Path) -> None:
    def given(kind: str, name: str, seed: int = 0) -> dict[str, str]:
        path = study.path(kind, name, seed) / NOTE
        return json.loads(path.read_text()) if path.exists() else {}

    base, seed_1 = "representations/simclr/seed-0", "representations/hand_crafted/seed-1"
    assert given("representations", "simclr")["dataset"] == "representations/hand_crafted/seed-0"
    assert given("representations", "simclr", 1) == {"dataset": seed_1}
    assert given("worlds", "unrefined") == {}, "another world shares nothing"
    assert given("variants", "cosine")["encoder"] == base
    assert "search" not in given("variants", "cosine")
    assert given("variants", "other_length")["encoder"] == base, "its length is none of the encoder's business"
    assert given("variants", "six").keys() == {"dataset", "encoder", "search"}
    alone = tmp_path / "alone"
    settings = open_folder(study.path("variants", "cosine", 0)).settings
    settings.folder, settings.resume = str(alone), None
    run(settings, given=True, context=RunContext())
    ours, theirs = discovery.load_run(study.path("variants", "cosine", 0)), discovery.load_run(alone)
    np.testing.assert_array_equal(ours.embeddings, theirs.embeddings)
    np.testing.assert_array_equal(ours.clusters.medoids, theirs.clusters.medoids)


def test_a_changed_setting_shares_no_more_than_it_may(study: Study, tmp_path: Path) -> None:
    other = Study(tmp_path / "b")
    other.everything = [
        *[each for each in study.everything if finished(each.path)],
        *[each for each in other.everything if each.entry.name == "six" and each.seed == 1],
    ]
    assert other.run(Runs(), ["six"]) == []
    told = json.loads((other.path("variants", "six", 1) / NOTE).read_text())
    assert told.keys() == {"dataset", "encoder", "search"}
    assert all(donor.endswith("/seed-1") for donor in told.values()), "those of its own seed"


def test_a_stage_that_a_run_has_begun_is_its_own_and_a_damaged_one_is_not_taken(
    study: Study, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (six,) = (each for each in Study(tmp_path / "e").everything if each.entry.name == "six" and each.seed == 1)
    (simclr,) = (each for each in study.everything if each.entry.name == "simclr" and each.seed == 1)
    damaged = dataclasses.replace(simclr, path=tmp_path / "damaged")
    shutil.copytree(simclr.path, damaged.path)
    (damaged.path / "encoder.safetensors").write_bytes((simclr.path / "encoder.safetensors").read_bytes()[:-100])
    first = open_folder(simclr.path).read_tensors("dataset/00000.safetensors")
    assert first is not None
    with make_folder(six.settings) as folder:
        folder.write_tensors("dataset/00000.safetensors", first.tensors, first.metadata)
        assert reuse_stages(folder, [damaged]).keys() == {"search"}
        assert "encoder.safetensors: not readable" in capsys.readouterr().err
        assert reuse_stages(folder, [simclr]).keys() == {"search", "encoder"}
        assert not (folder.path / "dataset" / "00001.safetensors").exists()


def test_what_is_finished_is_not_done_again_and_a_failure_does_not_stop_the_rest(
    study: Study, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    again = Runs()
    assert study.run(again, ["hand_crafted", "simclr"]) == []
    assert again.made == []
    other = Study(tmp_path / "c")
    assert other.run(Runs(fail="hand_crafted-0"), ["hand_crafted"]) == ["representations, hand_crafted, seed 0: ended with status 1"]
    assert "2 planned, 0 finished already" in capsys.readouterr().out
    later = Runs()
    assert other.run(later, ["hand_crafted"]) == []
    assert later.made == ["hand_crafted-0"], "seed 1 had been made"


def test_a_run_that_is_not_the_plans_is_refused_before_anything_runs(study: Study, tmp_path: Path) -> None:
    check_folders(study.everything)
    changed = read_plan(study.file, "quick")
    (entry,) = (each for each in changed.entries if each.name == "cosine")
    for words, threads, told in (
        ((), 2, None),
        (("report.map_points=30",), 1, None),
        (("search.crossover=0.5",), 1, "holds a run with search.crossover=0.7, the plan says 0.5; delete the folder"),
        (("dataset.videos=30",), 1, "give the entry cosine another name"),
    ):
        other = plan_runs(changed, [dataclasses.replace(entry, overrides=(*entry.overrides, *words))], 1, study.out, threads)
        if told is None:
            check_folders(other)
        else:
            with pytest.raises(DiscoveryError, match=told):
                check_folders(other)
    begun = plan_runs(changed, changed.of("representations")[:1], 1, tmp_path, 2)
    make_folder(begun[0].settings)
    (failure,) = run_all(plan_runs(changed, changed.of("representations")[:1], 1, tmp_path, 1), [], Runs())
    assert "the run began with threads=2, this command says 1" in failure


@pytest.fixture(scope="module")
def evaluations(study: Study) -> Evaluations:
    made = Evaluations(study.plan, study.everything, study.out / "evaluations", 1)
    made.make()
    return made


def test_the_table_of_variants_holds_every_entry_by_the_papers_measures(study: Study, evaluations: Evaluations) -> None:
    told = json.loads((evaluations.out / "variants" / "variants.json").read_text())
    rows = {row["name"]: row for row in told["variants"]}
    assert list(rows) == ["hand_crafted", "simclr", "cosine", "other_length", "six"]
    assert told["labels_given_by"] == "rules"
    for name, row in rows.items():
        kind = "variants" if name in ("cosine", "other_length", "six") else "representations"
        found = [discovery.load_run(study.path(kind, name, seed)) for seed in range(row["runs"])]
        names = [{medoid.label for medoid in each.medoids} - {"random"} for each in found]
        assert row["unique_each_run"] == [len(each) for each in names]
        assert row["evaluations"] == [24] * row["runs"]
        assert row["goals_met"]["unique"] is None, "fewer than five runs say little"
    assert rows["simclr"]["runs"] == 2
    assert rows["hand_crafted"]["goals_met"]["triplets"] is None, "it is what is to be beaten"
    assert rows["cosine"]["triplets"] != rows["simclr"]["triplets"], "judged by its own distance"
    assert rows["six"]["triplets"].keys() == told["test_set"].keys()


def test_a_goal_is_met_by_five_runs_and_not_by_four() -> None:
    medoids = ["aggregation", "dispersal", "cyclic pursuit", *["random"] * 3, *["dispersal"] * 4]

    def made(runs: int, accuracy: float) -> Variant:
        return Variant("a", "variants", "", (), [5000] * runs, Found("a", [medoids] * runs), np.full((runs, 2), accuracy))

    base = made(5, 0.7)
    assert made(5, 0.8).goals(base) == {"unique": True, "random": True, "triplets": True}
    assert made(4, 0.8).goals(base) == {"unique": None, "random": None, "triplets": True}
    assert made(5, 0.7).goals(base)["triplets"] is False
    one_more = Found("a", [medoids] * 4 + [["random"] * 4 + ["dispersal"] * 6])
    assert dataclasses.replace(base, found=one_more).goals(None) == {"unique": False, "random": False, "triplets": None}


def test_evaluations_whose_runs_have_not_changed_are_left_alone(
    study: Study, evaluations: Evaluations, capsys: pytest.CaptureFixture[str]
) -> None:
    names = ("representations", "tsne", "behaviours", "transfer", "variants")
    before = {name: (evaluations.out / name / f"{name}.json").stat().st_mtime_ns for name in names}
    Evaluations(study.plan, study.everything, evaluations.out, 1).make()
    assert {name: (evaluations.out / name / f"{name}.json").stat().st_mtime_ns for name in names} == before
    assert capsys.readouterr().out.count("is there") == 5


def test_the_page_has_every_table_and_keeps_what_a_person_wrote(study: Study, evaluations: Evaluations, tmp_path: Path) -> None:
    page = tmp_path / "study.md"
    write_page(page, study.plan, evaluations, {"imagenet": "no weights"}, 2)
    text = page.read_text()
    for words in (
        "## Representations (Figure 3)", "## Maps (Figure 4)", "## Behaviours of the ten medoids (Table 1)", "## What survives (Table 2)",
        "## Better than the paper",
        "Labels are given by rules", "simulated annotator", "Left out: `imagenet`, no weights.", "`cosine` (1 of 2)", "2.60 ± 0.33", "✗✗✗",
        "| ImageNet | random weights, as asked |", "| `unrefined, own speed` |", "| *paper: SimCLR* | 2.00 ± 0.00 |", EMPTY,
    ):  # fmt: skip
        assert words in text, words
    assert "{{" not in text
    assert "nan" not in text.lower().replace("finance", "")
    for line in text.split("\n\n"):
        if line.startswith("|"):
            cells = {row.count("|") for row in line.splitlines()}
            assert len(cells) == 1, f"a broken table: {line}"
    for name in ("representations", "tsne", "behaviours", "transfer", "variants"):
        assert f"(study_{name}.png)" in text
    assert sum(path.stat().st_size for path in tmp_path.iterdir()) < 1_000_000
    page.write_text(text.replace(EMPTY, "The encoder is too small.\n"))
    write_page(page, study.plan, evaluations, {}, 2)
    assert "The encoder is too small.\n" in page.read_text()
    assert EMPTY not in page.read_text()
    page.write_text("# Something else\n")
    with pytest.raises(DiscoveryError, match="has 0 sections marked as"):
        write_page(page, study.plan, evaluations, {}, 2)
    assert page.read_text() == "# Something else\n"


def test_a_persons_labels_of_the_test_set_are_used_and_named(study: Study, tmp_path: Path) -> None:
    made = Evaluations(study.plan, [each for each in study.everything if each.entry.name == "hand_crafted"], tmp_path / "out", 1)
    test = made.test
    answers = open_answers(tmp_path / "labels.json", "labels", test.fingerprint, "Ada")
    for row in range(len(test.labels)):
        answers.add([row], ("milling", "dispersal")[row % 2])
    Evaluations(study.plan, made.done, made.out, 1, tmp_path / "labels.json").make()
    told = json.loads((made.out / "representations" / "representations.json").read_text())
    assert (told["labels_given_by"], told["classes"]) == ("Ada", ["dispersal", "milling"])
    write_page(tmp_path / "study.md", study.plan, made, {}, 2)
    assert "Figures 3 and 4 were labelled by Ada." in (tmp_path / "study.md").read_text()


def test_without_imagenets_weights_its_entry_is_left_out_and_said_so(monkeypatch: pytest.MonkeyPatch) -> None:
    from discovery.representations.imagenet import NoWeightsError
    from docs.studies.discovery_of_behaviours import weights

    def none() -> None:
        raise NoWeightsError("nobody answers")

    monkeypatch.setattr(weights, "imagenet_weights", none)
    assert without_weights(read_plan(STUDY, "quick")) == {"imagenet": "ImageNet's weights cannot be had (nobody answers)"}
    monkeypatch.setattr(weights, "imagenet_weights", dict)
    assert without_weights(read_plan(STUDY, "quick")) == {}


def test_the_command_lists_what_there_is(study: Study, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["--plan", str(study.file), "--out", str(study.out), "--seeds", "2", "--threads", "1", "--list"]
    assert main(words) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 12
    assert sum(line.startswith("finished") for line in lines) == 8
    assert sum(line.startswith("missing") for line in lines) == 4

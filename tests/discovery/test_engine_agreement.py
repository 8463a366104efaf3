"""A label that does not come back, and a behaviour that only one engine produces, are marked apart in the report and in the numbers."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from discovery import load_run
from discovery.clustering.engine_agreement import STARTS, compare_engines, describe, engines_agree, majority
from discovery.command import RunContext, run
from discovery.controllers import FloatArray
from discovery.rollouts.simulator import Simulator
from swarm_envs import Trajectories, load_world
from swarm_envs.worlds import PushableObject, WorldSpec
from tests.discovery.tiny_run import tiny

PURSUIT, HEAP = [0.07, -1.3, 0.06, 1.1], [-0.09, -1.2, 0.0, -1.6]
LABELS = ["cyclic pursuit", "aggregation"]
HONEST = Simulator.__call__


def simulator(engine: str = "chipmunk", world: WorldSpec | None = None, steps: int = 600) -> Simulator:
    return Simulator(world or load_world("hero_plus"), engine, steps, 1)


def hide_a_disagreement(monkeypatch: pytest.MonkeyPatch, engine: str) -> None:
    """With this engine robots stand where the start put them."""

    def stuck(self: Simulator, controllers: FloatArray, seed: int, first: int = 0) -> Trajectories:
        honest = HONEST(self, controllers, seed, first)
        return (
            dataclasses.replace(honest, poses=np.repeat(honest.poses[:, :1], honest.poses.shape[1], axis=1))
            if self.engine == engine
            else honest
        )

    monkeypatch.setattr(Simulator, "__call__", stuck)


@pytest.mark.parametrize(("engine", "other"), [("chipmunk", "disc"), ("disc", "chipmunk")])
def test_the_engines_agree_on_plain_behaviours_whose_labels_repeat(engine: str, other: str) -> None:
    found = compare_engines(simulator(engine), np.array([PURSUIT, HEAP]), LABELS, seed=0)
    assert [each.agree for each in found] == [True, True]
    assert [each.repeats for each in found] == [True, True]
    assert [each.other_label for each in found] == LABELS
    assert {each.engine for each in found} == {other}
    assert describe(found) == f"2 of 2 labels repeat from most new starts; {other} agrees on 2 of 2"


def test_the_engines_differ_on_a_behaviour_of_one_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    hide_a_disagreement(monkeypatch, "disc")
    found = compare_engines(simulator(), np.array([PURSUIT, HEAP]), LABELS, seed=0)
    assert [(each.agree, each.own_label, each.other_label, each.votes) for each in found] == [
        (False, "cyclic pursuit", "random", STARTS),
        (False, "aggregation", "random", STARTS),
    ]
    assert describe(found) == "2 of 2 labels repeat from most new starts; disc agrees on 0 of 2"


def test_engines_that_agree_with_each_other_do_not_make_a_wrong_label_repeat() -> None:
    (found,) = compare_engines(simulator("disc"), np.array([PURSUIT]), ["dispersal"], seed=0)
    assert (found.agree, found.repeats, found.repeated) == (True, False, 0)
    told = found.summary()
    assert told["engine_agreement"]["agree"] is True
    assert told["label_repeatability"] == {"starts": STARTS, "repeated": 0, "label_by_majority": "cyclic pursuit"}


def test_a_world_that_the_disc_engine_refuses_is_not_checked_and_says_why() -> None:
    world = dataclasses.replace(load_world("hero_plus"), objects=(PushableObject("disc", (0.05,), (0.2, 0.2, 0.0)),))
    found = compare_engines(simulator(world=world), np.array([PURSUIT]), LABELS[:1], seed=0)
    told = found[0].summary()["engine_agreement"]
    assert found[0].agree is None
    assert told["agree"] is None
    assert "cannot push objects" in told["not_checked"]
    assert "; disc not asked: " in describe(found)


def test_the_majority_decides_and_the_runs_own_label_between_equals() -> None:
    assert majority(["a", "b", "b"], "a") == "b"
    assert majority(["c", "c", "b", "b", "a"], "c") == "c"
    assert majority(["c", "c", "b", "b", "a"], "a") == "b"


def test_every_card_of_the_report_and_every_medoid_in_the_numbers_says_what_the_other_engine_makes_of_it(finished: Path) -> None:
    page, medoids = (finished / "report.html").read_text(encoding="utf-8"), json.loads((finished / "metrics.json").read_text())["medoids"]
    agreed = [engines_agree(medoid) for medoid in medoids]
    assert len(agreed) == 10
    assert page.count("engines agree: disc shows") == agreed.count(True)
    assert page.count("<b>engines differ</b>") == agreed.count(False)
    repeated = [medoid["label_repeatability"]["label_by_majority"] == medoid["label"] for medoid in medoids]
    assert page.count('class="check">label repeats:') == repeated.count(True)
    assert page.count("<b>label does not repeat</b>") == repeated.count(False)


def test_what_earlier_runs_call_confirmed_is_read_as_agreement_of_the_engines() -> None:
    medoids = load_run(Path(__file__).parent / "earlier_runs" / "finished").metrics["medoids"]
    assert [engines_agree(medoid) for medoid in medoids] == [medoid["confirmation"]["confirmed"] for medoid in medoids] == [True] * 4


def test_a_run_whose_other_engine_disagrees_marks_it_on_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    hide_a_disagreement(monkeypatch, "disc")
    settings = tiny(f"folder={tmp_path / 'run'}", f"search.include=[{PURSUIT},{HEAP}]", "steps=400")
    run(settings, given=True, context=RunContext())
    page = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    medoids = json.loads((tmp_path / "run" / "metrics.json").read_text())["medoids"]
    doubtful = [medoid for medoid in medoids if engines_agree(medoid) is False]
    assert doubtful, "the tiny archive held nothing but random behaviours"
    assert all(medoid["engine_agreement"]["other_label_by_majority"] == "random" for medoid in doubtful)
    assert page.count("<b>engines differ</b>") == len(doubtful)

"""A behaviour that only one engine produces is marked in the report and in the run's numbers."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest

from discovery.clustering.engine_agreement import STARTS, confirm, describe, majority
from discovery.command import Opened, run
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

    def stuck(self: Simulator, controllers: FloatArray, seed: int) -> Trajectories:
        honest = HONEST(self, controllers, seed)
        return (
            dataclasses.replace(honest, poses=np.repeat(honest.poses[:, :1], honest.poses.shape[1], axis=1))
            if self.engine == engine
            else honest
        )

    monkeypatch.setattr(Simulator, "__call__", stuck)


@pytest.mark.parametrize(("engine", "other"), [("chipmunk", "disc"), ("disc", "chipmunk")])
def test_plain_behaviours_are_confirmed_by_the_other_engine(engine: str, other: str) -> None:
    found = confirm(simulator(engine), np.array([PURSUIT, HEAP]), LABELS, seed=0)
    assert [each.confirmed for each in found] == [True, True]
    assert [each.other_label for each in found] == LABELS
    assert {each.engine for each in found} == {other}
    assert describe(found) == f"2 of 2 confirmed by {other}"


def test_a_behaviour_of_one_engine_alone_is_not_confirmed(monkeypatch: pytest.MonkeyPatch) -> None:
    hide_a_disagreement(monkeypatch, "disc")
    found = confirm(simulator(), np.array([PURSUIT, HEAP]), LABELS, seed=0)
    assert [(each.confirmed, each.label, each.other_label, each.votes) for each in found] == [
        (False, "cyclic pursuit", "random", STARTS),
        (False, "aggregation", "random", STARTS),
    ]
    assert describe(found) == "0 of 2 confirmed by disc"


def test_a_world_that_the_disc_engine_refuses_is_not_checked_and_says_why() -> None:
    world = dataclasses.replace(load_world("hero_plus"), objects=(PushableObject("disc", (0.05,), (0.2, 0.2, 0.0)),))
    found = confirm(simulator(world=world), np.array([PURSUIT]), LABELS[:1], seed=0)
    assert found[0].confirmed is None
    assert found[0].summary()["confirmed"] is None
    assert "cannot push objects" in found[0].summary()["not_checked"]
    assert describe(found).startswith("not checked with disc: ")


def test_the_majority_decides_and_the_runs_own_label_between_equals() -> None:
    assert majority(["a", "b", "b"], "a") == "b"
    assert majority(["c", "c", "b", "b", "a"], "c") == "c"
    assert majority(["c", "c", "b", "b", "a"], "a") == "b"


def test_every_card_of_the_report_and_every_medoid_in_the_numbers_says_what_the_other_engine_makes_of_it(finished: Path) -> None:
    page, medoids = (finished / "report.html").read_text(encoding="utf-8"), json.loads((finished / "metrics.json").read_text())["medoids"]
    confirmed = [medoid["confirmation"]["confirmed"] for medoid in medoids]
    assert len(confirmed) == 10
    assert page.count('class="check">confirmed by disc:') == confirmed.count(True)
    assert page.count("<b>not confirmed by disc</b>") == confirmed.count(False)


def test_a_run_whose_other_engine_disagrees_marks_it_on_the_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    hide_a_disagreement(monkeypatch, "disc")
    settings = tiny(f"folder={tmp_path / 'run'}", f"search.include=[{PURSUIT},{HEAP}]", "steps=400")
    run(settings, given=True, opened=Opened())
    page = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    medoids = json.loads((tmp_path / "run" / "metrics.json").read_text())["medoids"]
    doubtful = [medoid for medoid in medoids if medoid["confirmation"]["confirmed"] is False]
    assert doubtful, "the tiny archive held nothing but random behaviours"
    assert all(medoid["confirmation"]["other_label_by_majority"] == "random" for medoid in doubtful)
    assert page.count("<b>not confirmed by disc</b>") == len(doubtful)

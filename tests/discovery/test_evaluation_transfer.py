"""What survives in another world: the definitions against cases with known answers, and the command on real runs of two worlds."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from discovery.command import RunContext, run
from discovery.evaluation.command import main
from discovery.evaluation.groups import interval
from discovery.evaluation.transfer import OWN_SPEED, Transferred, mark, mean_distances, slow_down, within
from discovery.evaluation.transfer_tables import by_behaviour, marks, survival
from swarm_envs.worlds import load_world
from tests.discovery.tiny_run import tiny


def flags(text: str) -> np.ndarray:
    return np.array([letter == "1" for letter in text])


def medoid(world: str, seed: int, label: str, labels: list[str], home: list[float], target: list[float]) -> Transferred:
    return Transferred(world, seed, 1, np.zeros(4), label, 1.0, [label, label, "random", label], labels, np.array(home), np.array(target))


def test_marks_are_those_of_the_papers_table() -> None:
    assert [mark(flags(text)) for text in ("1000", "0100", "0010", "0001", "0000")] == ["✓", "◐", "◐", "✗", "✗"]


def test_the_chance_within_three_attempts_is_that_of_drawing_three_of_those_made() -> None:
    attempts = flags("1100000000")
    draws = np.random.default_rng(0)
    drawn = np.mean([attempts[draws.choice(10, 3, replace=False)].any() for _ in range(20_000)])
    assert within(attempts, 3) == pytest.approx(drawn, abs=0.01)
    assert within(attempts, 1) == pytest.approx(0.2)
    assert within(flags("0000"), 3) == 0.0
    assert within(flags("0110"), 3) == 1.0, "three of four cannot all fail when two succeed"


def test_runs_like_those_at_home_survive_nineteen_times_in_twenty_and_others_do_not() -> None:
    draws = np.random.default_rng(1)
    survived = {0.0: [], 6.0: []}  # type: dict[float, list[bool]]
    for _ in range(60):
        home = draws.normal(size=(60, 5))
        for shift, found in survived.items():
            own, others = mean_distances(draws.normal(size=(60, 5)) + shift, home)
            found += (others <= np.quantile(own, 0.95)).tolist()
    assert np.mean(survived[0.0]) == pytest.approx(0.95, abs=0.02)
    assert np.mean(survived[6.0]) == 0.0


def test_fast_controllers_are_slowed_down_by_one_factor() -> None:
    world = load_world("hero_plus")  # 9 cm/s, 1.6 rad/s
    controllers = np.array([[0.18, -1.6, 0.05, 0.4], [0.09, 1.6, -0.09, -1.6], [0.01, 3.2, 0.0, 0.0]])
    factors = slow_down(controllers, world)
    np.testing.assert_allclose(factors, [0.5, 1.0, 0.5])


def test_random_medoids_do_not_count_and_intervals_are_over_runs() -> None:
    found = [
        medoid("a", 0, "milling", ["milling", "random", "random", "milling"], [1.0, 1.0, 1.0, 2.0], [1.0, 9.0, 9.0, 9.0]),
        medoid("a", 0, "random", ["random"] * 4, [1.0] * 4, [1.0] * 4),
        medoid("a", 1, "milling", ["random", "milling", "random", "random"], [1.0] * 4, [9.0] * 4),
        medoid("b", 0, "random", ["random"] * 4, [1.0] * 4, [1.0] * 4),
    ]
    first, second = survival(found)
    assert (first.world, first.runs, first.medoids) == ("a", 2, 2)
    assert first.first == {"label": 1, "metrics": 1}
    assert first.within_three == {"label": 2, "metrics": 1}
    assert first.one_attempt["label"] == pytest.approx(interval([0.5, 0.25]))
    assert first.home[0] == pytest.approx(0.75)
    assert (second.medoids, second.first["label"]) == (0, 0)
    assert np.isnan(second.one_attempt["label"][0])
    table = by_behaviour(found)["a"]["milling"]
    assert (table["medoids"], table["runs"], table["label"]) == (2, 2, first.one_attempt["label"])
    assert by_behaviour(found)["b"].keys() == {"random"}
    assert marks(found, "label")["a"]["milling"] == {0: "✓", 1: "◐"}
    assert marks(found, "metrics")["a"]["milling"] == {0: "✓", 1: "✗"}
    assert all(cells == {0: "-"} for cells in marks(found, "metrics")["b"].values())
    assert "random" not in marks(found, "label")["a"]


def test_an_interval_of_one_run_has_no_ends_and_none_leaves_its_range() -> None:
    assert interval([0.4])[0] == 0.4
    assert np.isnan(interval([0.4])[1:]).all()
    assert interval([0.0, 1.0])[1:] == (0.0, 1.0)
    low, high = interval([0.4, 0.5, 0.6])[1:]
    assert (low, high) == pytest.approx((0.5 - 4.303 * 0.1 / np.sqrt(3), 0.5 + 4.303 * 0.1 / np.sqrt(3)), abs=1e-3)


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    folder, paths = tmp_path_factory.mktemp("transferred"), []
    for world in ("unrefined", "hero_plus"):
        paths.append(str(folder / world))
        words = ("steps=150", "representation=hand_crafted", f"world={world}", f"folder={paths[-1]}")
        run(tiny(*words, simclr=False), given=True, context=RunContext())
    return paths


def test_the_command_runs_medoids_again_in_the_target_world(runs: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["transfer", *runs, "--out", str(tmp_path), "--starts", "4", "--threads", "1"]) == 0
    told = json.loads((tmp_path / "transfer.json").read_text())
    assert (told["labels_given_by"], told["target"], told["starts"]) == ("rules", "hero_plus", 4)
    worlds = ["unrefined", f"unrefined{OWN_SPEED}", "hero_plus"]
    assert [entry["world"] for entry in told["survival"]] == worlds
    assert len(told["medoids"]) == 30
    limits = np.array([0.09, 1.6] * 2)
    for entry in told["medoids"]:
        over = (np.abs(entry["controller"]) / limits).max()
        assert entry["slowed"] == pytest.approx(1 / max(over, 1) if entry["world"] == "unrefined" else 1.0)
        assert len(entry["labels"]) == len(entry["home_labels"]) == len(entry["distances"]) == 4
    assert any(entry["slowed"] < 1 for entry in told["medoids"])
    home = [entry["distances"] for entry in told["medoids"] if entry["world"] == "hero_plus"]
    away = [entry["distances"] for entry in told["medoids"] if entry["world"] == "unrefined"]
    assert np.median(home) < np.median(away), "slowing down and friction change more than another start does"
    rows = list(csv.DictReader((tmp_path / "transfer.csv").read_text().splitlines()))
    assert len(rows) == 30
    for ending in ("png", "svg"):
        assert (tmp_path / f"transfer.{ending}").stat().st_size > 5000
    assert "survive at the first attempt" in capsys.readouterr().out


def test_runs_of_several_representations_and_too_few_starts_are_refused(
    runs: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = str(tmp_path / "other")
    run(tiny("steps=150", "representation=hand_crafted_standardised", f"folder={other}", simclr=False), given=True, context=RunContext())
    assert main(["transfer", runs[0], other, "--out", str(tmp_path / "out")]) == 1
    assert "the runs differ in representation, engine or steps" in capsys.readouterr().err
    assert main(["transfer", runs[0], "--out", str(tmp_path / "out"), "--starts", "2"]) == 1
    assert "given 2, expected at least 3" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()

"""The study counts what it should."""

from __future__ import annotations

import numpy as np

from docs.studies.calibration.draws import Outcome, Task, names_of
from docs.studies.calibration.generator import EFFECTS, drawn_extra, generate_log
from docs.studies.calibration.sides import runs_on_either_side
from docs.studies.calibration.study import read_outcomes
from docs.studies.calibration.tally import as_demanded, covered, found, report, table
from swarm_envs.calibration import read_log

RIGHT = Outcome("a", "singles", {"turn_bias": {"bias": 0.5}}, named={"turn_bias": {"bias": (0.49, 0.45, 0.53)}})
OFF = Outcome("b", "singles", {"turn_bias": {"bias": 0.5}}, named={"turn_bias": {"bias": (0.4, 0.35, 0.45)}, "motor_lag": {}})
CONFOUNDED = Outcome(
    "c",
    "singles",
    {"clock_offset": {"offset": 0.2}},
    named={"dead_time": {"delay": (0.2, 0.19, 0.21)}},
    groups=[["dead_time", "clock_offset"]],
)
MISSED = Outcome("d", "nulls", {})


def test_a_truth_is_covered_only_inside_every_interval():
    assert found(RIGHT, "turn_bias")
    assert covered(RIGHT, "turn_bias")
    assert found(OFF, "turn_bias")
    assert not covered(OFF, "turn_bias")


def test_a_confounded_effect_counts_as_found_when_the_calibration_says_so():
    assert found(CONFOUNDED, "clock_offset")
    assert covered(CONFOUNDED, "clock_offset")
    silent = Outcome("e", "singles", CONFOUNDED.hidden, named=CONFOUNDED.named)
    assert not found(silent, "clock_offset")


def test_an_unlisted_effect_counts_when_its_dependence_is_right_and_its_error_is_halved_at_every_horizon():
    def outcome(depends_on: str, cut: list[float], cut_world: list[float]) -> Outcome:
        found = Outcome("f", "unlisted", {}, extra="slippery_patch", unexplained=depends_on, channel="forward speed")
        found.cut, found.cut_world = cut, cut_world
        return found

    half = [0.5, 0.6, 0.7]
    assert as_demanded(outcome("place", half, half))
    assert not as_demanded(outcome("place", [0.4, 0.6, 0.7], half))
    assert not as_demanded(outcome("place", half, [0.6, 0.4, 0.7]))
    assert not as_demanded(outcome("robot", half, half))


def test_runs_are_counted_on_and_beside_a_patch(tmp_path):
    log = read_log(generate_log({}, tmp_path / "log", seed=73030041, extra="slippery_patch"))
    patch = drawn_extra("slippery_patch", 73030041)
    inside, _ = patch(np.ones(1), np.zeros(1), np.zeros(1), np.zeros(1), np.zeros(1))
    assert inside[0] < 1
    # of ten runs one leaves the patch
    assert runs_on_either_side(log, patch) == (1, 10)


def test_the_report_counts_each_kind():
    text = report([RIGHT, OFF, CONFOUNDED, MISSED])
    assert "| one effect, named | 3 of 3 |" in text
    assert "| one effect, named and nothing else | 2 of 3 |" in text
    assert "| one effect, truth in the interval | 2 of 3 |" in text
    assert "| no effect, something named | 0 of 1 |" in text
    assert "| turn_bias | 2 | 2 | 34 to 100 % | 1 of 2 |" in text
    confusion = next(line for line in text.splitlines() if line.startswith("| hidden | draws |"))
    assert confusion == "| hidden | draws | turn_bias | dead_time | motor_lag | nothing |"
    assert "| turn_bias | 2 | 2 |  | 1 |  |" in text
    assert "| clock_offset | 1 |  | 1 |  |  |" in text
    assert "| nothing | 1 |  |  |  | 1 |" in text


def test_the_table_has_a_row_for_each_parameter_hidden_or_named():
    rows = [row.split(",")[:4] for row in table([RIGHT, CONFOUNDED, MISSED]).splitlines()[1:]]
    assert [(row[0], row[3]) for row in rows] == [("a", "turn_bias"), ("c", "clock_offset"), ("c", "dead_time"), ("d", "")]


def test_two_effects_that_no_log_separates_are_not_hidden_together():
    for seed in range(300):
        names = names_of(Task("pairs", 0, seed, ("drives",)))
        assert len(set(names)) == 2
        assert set(names) != {"dead_time", "clock_offset"}
        assert all(EFFECTS[name].procedure == "drives" for name in names)


def test_a_line_cut_off_is_done_again(tmp_path):
    path = tmp_path / "draws.jsonl"
    path.write_text('{"key": "x", "kind": "nulls", "hidden": {}}\n{"key": "y", "ki')
    assert [outcome.key for outcome in read_outcomes(path)] == ["x"]

"""The report reads as an argument, and needs no other file."""

from __future__ import annotations

import itertools
import json
import re
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from swarm_envs import load_world
from swarm_envs.calibration import LogError, read_log
from swarm_envs.calibration.progress import share_after
from swarm_envs.calibration.report.figures import binned
from swarm_envs.calibration.report.page import _stable
from swarm_envs.calibration.report.player import view
from swarm_envs.calibration.report.replays import Replay
from swarm_envs.calibration.selection.causes import Cause, Estimate
from swarm_envs.calibration.validation import leave_one_out as stability

VOID = {"meta", "input", "br", "img", "use", "path"}


class Page(HTMLParser):
    """Elements in order, and whether every one is closed."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, dict(attrs)))

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self.open.pop() == tag


@pytest.fixture(scope="module")
def report(place: Path) -> str:
    return (place / "calibrated" / "report.html").read_text(encoding="utf-8")


def test_the_report_goes_from_what_is_wrong_over_why_to_what_is_gained(report: str) -> None:
    assert re.findall(r"<h2>(.*?)</h2>", report) == [
        "Wrong here",
        "Because of this",
        "Now predicted so",
        "See for yourself",
        "Data and use",
    ]


def test_the_report_needs_no_other_file(report: str) -> None:
    page = Page(report)
    assert page.open == []
    for tag, attributes in page.elements:
        assert tag not in ("link", "iframe")
        for name in ("src", "href", "xlink:href"):
            assert (attributes.get(name) or "#").startswith(("#", "data:")), (tag, attributes)
    assert not re.search(r"url\((?!#)", report)
    assert len(report) < 2_000_000


def test_every_picture_says_what_it_shows(report: str) -> None:
    pictures = [attributes for tag, attributes in Page(report).elements if tag in ("svg", "canvas", "img")]
    assert len(pictures) >= 5
    for attributes in pictures:
        assert attributes.get("role") == "img"
        assert len(attributes.get("aria-label") or "") > 15


def test_the_report_is_for_phones_and_for_the_dark(report: str) -> None:
    assert 'name="viewport"' in report
    assert "prefers-color-scheme: dark" in report
    assert "currentColor" in report
    assert "#010203" not in report


def test_the_report_has_the_numbers_of_the_findings(report: str, place: Path) -> None:
    findings = json.loads((place / "calibrated" / "findings.json").read_text())
    for cause in findings["causes"]:
        for number in cause["parameters"].values():
            assert f"{number['estimate']:.4g}" in report
            assert f"[{number['ci95'][0]:.4g}, {number['ci95'][1]:.4g}]" in report


def test_each_replay_holds_what_was_measured_and_both_predictions(report: str, place: Path) -> None:
    runs = [json.loads(text) for text in re.findall(r'<script type="application/json">(.*?)</script>', report)]
    assert 1 <= len(runs) <= 3
    log = read_log(place / "my_log")
    for run in runs:
        assert len(run["measured"][0]) == len(run["before"][0]) == len(run["after"][0])
        measured, before, after = (np.array(run[name][0]) for name in ("measured", "before", "after"))
        ends = [track.poses[-1, :2] for track in log.tracks]
        assert min(np.hypot(*(measured[-1, :2] - end)) for end in ends) < 0.01
        # the robots drive as the calibrated world says, to the end of the run
        assert np.hypot(*(after - measured)[-1, :2]) < 0.2 * np.hypot(*(before - measured)[-1, :2])


def driven(run: str, *ends: tuple[float, float]) -> Replay:
    """A robot that drives from the origin to an end each, as measured, before and after."""
    share = np.linspace(0, 1, 20)[:, None, None]
    measured, before, after = (share * np.array([*end, 0.0]) for end in ends)
    return Replay(run, measured, before, after, np.zeros((20, 1)))


def test_every_robot_of_a_replay_is_seen_whole() -> None:
    radius = 0.06
    for replay in (driven("near", (0.3, 0.1), (0.5, -0.2), (0.3, 0.1)), driven("far", (9.0, 0.1), (4.0, -8.0), (9.1, 0.1))):
        left, bottom, side = view(replay, None, radius)
        mark = 1.6 * max(radius, side / 60)
        places = np.concatenate([path[..., :2].reshape(-1, 2) for path in (replay.measured, replay.before, replay.after)])
        assert np.all(places - mark >= [left, bottom])
        assert np.all(places + mark <= [left + side, bottom + side])


def test_a_prediction_that_is_far_off_does_not_make_what_was_measured_tiny() -> None:
    _, _, side = view(driven("off", (0.5, 0.0), (80.0, 3.0), (0.5, 0.0)), None, 0.06)
    assert side < 2.5


def test_means_and_their_intervals_are_those_of_like_windows() -> None:
    generator = np.random.default_rng(0)
    values = np.repeat([0.0, 1.0, 2.0], 50)
    errors = values + generator.normal(0, 0.1, 150)
    found = binned(values, errors)
    assert found.centres.tolist() == [0, 1, 2]
    assert np.all(np.abs(found.means - [0, 1, 2]) < 2 * found.half_widths)
    assert found.half_widths == pytest.approx(1.96 * 0.1 / np.sqrt(50), rel=0.3)
    many = generator.normal(size=800)
    assert len(binned(many, many**2, 8).centres) == 8


def test_progress_never_falls_and_ends_near_one() -> None:
    share, shares = 0.0, []
    lines = ["turn_bias 9.0"] * 30 + ["fitted without part 1 of 6", "contact: wall_friction 1.0", "turn_bias 2.0", "writing the report"]
    for line in lines:
        share = share_after(line, share)
        shares.append(share)
    assert all(b >= a for a, b in itertools.pairwise(shares))
    assert 0.5 < shares[29] < 0.75
    assert 0.95 < share < 1.0


def cause(effect: str, value: float) -> Cause:
    return Cause(effect, {"gain": Estimate(value, (value - 0.01, value + 0.01), "1")}, 10.0, 1e-6, "It does.")


def test_leaving_runs_out_tells_what_holds(monkeypatch: pytest.MonkeyPatch, place: Path) -> None:
    def causes(log, world):
        # one run alone makes it look as if robots turned too fast
        found = (cause("linear_gain", 0.85 + 0.001 * len(log.runs[0])),)
        return found if "run_3" in log.runs else (*found, cause("angular_gain", 1.2))

    monkeypatch.setattr(stability, "_causes", causes)
    log = read_log(place / "my_log")
    found = stability.leave_one_out(log, load_world("hero_plus"), [cause("linear_gain", 0.85)])
    assert found.runs == 6
    assert found.named == {"linear_gain": 6, "angular_gain": 1}
    assert found.without["run_3"] == ("linear_gain", "angular_gain")
    assert not found.stable
    (moved,) = found.moved
    assert (moved.estimate, moved.least, moved.most) == pytest.approx((0.85, 0.855, 0.855))
    assert "1 of 6" in _stable(found)
    single = [track for track in log.tracks if track.run == "run_0"]
    with pytest.raises(LogError, match="one run only"):
        stability.leave_one_out(type(log)("it", tuple(single)), load_world("hero_plus"), [])

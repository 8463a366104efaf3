"""What is on no list is called unexplained, with what it depends on, and corrected; nothing is where there is nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from docs.studies.calibration.generator import generate_log
from swarm_envs import load_world
from swarm_envs.calibration import read_log
from swarm_envs.calibration.drive.identification import identify
from swarm_envs.calibration.residual.corrections import FORWARD
from swarm_envs.calibration.residual.criticism import criticise
from swarm_envs.calibration.residual.fit_piecewise_floor import fit_piecewise_floor
from swarm_envs.calibration.residual.residual_dynamics import find_residual_dynamics
from swarm_envs.calibration.residual.residuals import CHANNELS, Residuals, residuals
from swarm_envs.calibration.residual.smoothing import smooth_corrections

pytestmark = pytest.mark.slow

UNLISTED = {
    "slippery_patch": ("forward speed", "place"),
    "magnetic_stripe": ("turn rate", "place"),
    "heading_speed": ("forward speed", "heading"),
}


@pytest.mark.parametrize("extra", ["magnetic_stripe", "heading_speed"])
def test_an_effect_on_no_list_is_unexplained_by_what_it_depends_on_and_its_correction_halves_the_error(extra: str, tmp_path: Path) -> None:
    log = read_log(generate_log({}, tmp_path / "log", seed=5, runs=8, position_noise=5e-4, heading_noise=2e-3, extra=extra))
    found = find_residual_dynamics(log, identify(log, load_world("hero_plus")))
    assert found is not None
    assert (found.discrepancy.channel, found.discrepancy.depends_on) == UNLISTED[extra]
    for row in found.heldout:
        before, after = (row.heading_before, row.heading_after) if extra == "magnetic_stripe" else (row.position_before, row.position_after)
        assert after < 0.5 * before


def test_a_patch_that_robots_who_differ_would_explain_too_is_unexplained_and_they_are_not_named(tmp_path: Path) -> None:
    # some robots drive on the patch and some beside it
    log = read_log(generate_log({}, tmp_path / "log", seed=53030005, extra="slippery_patch"))
    identified = identify(log, load_world("hero_plus"))
    assert [cause.effect for cause in identified.causes] == ["robot_spread"]
    found = find_residual_dynamics(log, identified)
    assert found is not None
    assert (found.discrepancy.channel, found.discrepancy.depends_on) == UNLISTED["slippery_patch"]
    assert found.remaining(identified).causes == ()
    assert all(row.position_after < 0.5 * row.position_before for row in found.heldout)


def test_robots_that_differ_stay_named_and_those_of_other_runs_are_taken_for_average(tmp_path: Path) -> None:
    effects = {"robot_spread": {"sd": 0.1}, "linear_gain": {"gain": 0.75}}
    log = read_log(generate_log(effects, tmp_path / "log", seed=2, runs=5, position_noise=2e-3, heading_noise=2e-3, procedures=["drives"]))
    identified = identify(log, load_world("hero_plus"))
    assert {cause.effect for cause in identified.causes} == set(effects)
    assert find_residual_dynamics(log, identified) is None


def windows_over_a_disc(generator: np.random.Generator) -> Residuals:
    """Windows in which robots cross a floor that halves their speed within 0.3 m of the middle, with noise of a tenth of that."""
    windows, moments, speed = 400, 8, 0.1
    begin, way = generator.uniform(-0.6, 0.6, (windows, 1, 2)), generator.uniform(0, 2 * np.pi, windows)
    gone = 0.05 * (np.arange(moments) + 0.5) / moments
    places = begin + gone[:, None] * np.column_stack([np.cos(way), np.sin(way)])[:, None]
    slowed = -0.5 * speed * (np.hypot(places[..., 0], places[..., 1]) < 0.3).mean(axis=1)
    errors = generator.normal(0, 5e-3, (windows, 3))
    errors[:, 0] += slowed
    motion = np.tile([speed, 0.0], (windows, 1))
    along = np.concatenate([places, np.tile([speed, 0.0], (windows, moments, 1))], axis=2)
    nothing, number = np.zeros(windows), np.arange(windows)
    names = ("commanded speed", "commanded turn rate", "time since a start", "time in the run", "heading", "robot")
    return Residuals(errors, dict.fromkeys(names, nothing), places.mean(axis=1), motion, along, number // 10, number // 40)


def test_a_floor_of_two_kinds_is_found_with_its_levels_and_beats_a_smooth_function() -> None:
    found = windows_over_a_disc(np.random.default_rng(1))
    trials = [t for t in smooth_corrections(found) if (t.channel, t.regressor, t.basis.depends_on) == (FORWARD, "speed", "place")]
    smooth = max(trials, key=lambda trial: trial.gain)
    floor = fit_piecewise_floor(smooth, found)
    assert floor.gain > smooth.gain + 100
    inside, outside = floor.term.basis.weighed(np.array([[0.0, 0.0], [0.5, 0.0]]), floor.term.weights)
    assert (inside, outside) == (pytest.approx(-0.5, abs=0.03), pytest.approx(0.0, abs=0.03))


def test_without_anything_hidden_nothing_is_unexplained(tmp_path: Path) -> None:
    log = read_log(generate_log({}, tmp_path / "log", seed=6, runs=6, position_noise=5e-4, heading_noise=2e-3, procedures=["drives"]))
    found = identify(log, load_world("hero_plus"))
    assert find_residual_dynamics(log, found) is None
    assert criticise(residuals(log, found.model, found.robots)) == []


def drawn(generator: np.random.Generator, slope: float) -> Residuals:
    """Windows of which ten in a row err alike, and whose forward speed may depend on a covariate that changes as slowly."""
    blocks, inside = 40, 10
    block = np.repeat(np.arange(blocks), inside)
    slow = np.repeat(generator.normal(size=blocks), inside)
    errors = np.repeat(generator.normal(size=(blocks, len(CHANNELS))), inside, axis=0) + 0.3 * generator.normal(size=(len(block), 3))
    errors[:, 0] += slope * slow
    motion = np.column_stack([np.full(len(block), 0.1), np.zeros(len(block))])
    return Residuals(errors, {"heading": slow}, np.zeros((len(block), 2)), motion, np.zeros((len(block), 8, 4)), block, block)


def test_errors_that_come_in_blocks_are_not_taken_for_a_dependence() -> None:
    generator = np.random.default_rng(3)
    assert sum(bool(criticise(drawn(generator, 0.0))) for _ in range(20)) <= 1


def test_a_dependence_is_seen_behind_errors_that_come_in_blocks() -> None:
    entries = criticise(drawn(np.random.default_rng(4), 3.0))
    assert ("forward speed", "heading") in {(entry.channel, entry.depends_on) for entry in entries}
    assert {entry.channel for entry in entries} == {"forward speed"}

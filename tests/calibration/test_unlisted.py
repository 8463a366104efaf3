"""What is on no list is called unexplained, with what it depends on, and corrected; nothing is where there is nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from swarm_envs import load_world
from swarm_envs.calibration import read_log
from swarm_envs.calibration.criticism import CHANNELS, Residuals, criticise, residuals
from swarm_envs.calibration.identification import identify
from swarm_envs.calibration.unlisted import find_unlisted

pytest.importorskip("tests.calibration.generator")
from tests.calibration.generator import generate_log

UNLISTED = {
    "slippery_patch": ("forward speed", "place"),
    "magnetic_stripe": ("turn rate", "place"),
    "heading_speed": ("forward speed", "heading"),
}


@pytest.mark.parametrize("extra", UNLISTED)
def test_an_effect_on_no_list_is_unexplained_by_what_it_depends_on_and_its_correction_halves_the_error(extra: str, tmp_path: Path) -> None:
    log = read_log(generate_log({}, tmp_path / "log", seed=5, runs=8, position_noise=5e-4, heading_noise=2e-3, extra=extra))
    found = find_unlisted(log, identify(log, load_world("hero_plus")))
    assert found is not None
    assert (found.discrepancy.channel, found.discrepancy.depends_on) == UNLISTED[extra]
    for row in found.heldout:
        before, after = (row.heading_before, row.heading_after) if extra == "magnetic_stripe" else (row.position_before, row.position_after)
        assert after < 0.5 * before


def test_without_anything_hidden_nothing_is_unexplained(tmp_path: Path) -> None:
    log = read_log(generate_log({}, tmp_path / "log", seed=6, runs=6, position_noise=5e-4, heading_noise=2e-3, procedures=["drives"]))
    found = identify(log, load_world("hero_plus"))
    assert find_unlisted(log, found) is None
    assert criticise(residuals(log, found.model, found.robots)) == []


def drawn(generator: np.random.Generator, slope: float) -> Residuals:
    """Windows of which ten in a row err alike, and whose forward speed may depend on a circumstance that changes as slowly."""
    blocks, inside = 40, 10
    block = np.repeat(np.arange(blocks), inside)
    slow = np.repeat(generator.normal(size=blocks), inside)
    errors = np.repeat(generator.normal(size=(blocks, len(CHANNELS))), inside, axis=0) + 0.3 * generator.normal(size=(len(block), 3))
    errors[:, 0] += slope * slow
    motion = np.column_stack([np.full(len(block), 0.1), np.zeros(len(block))])
    return Residuals(errors, {"heading": slow}, np.zeros((len(block), 2)), motion, block, block)


def test_errors_that_come_in_blocks_are_not_taken_for_a_dependence() -> None:
    generator = np.random.default_rng(3)
    assert sum(bool(criticise(drawn(generator, 0.0))) for _ in range(20)) <= 1


def test_a_dependence_is_seen_behind_errors_that_come_in_blocks() -> None:
    entries = criticise(drawn(np.random.default_rng(4), 3.0))
    assert ("forward speed", "heading") in {(entry.channel, entry.depends_on) for entry in entries}
    assert {entry.channel for entry in entries} == {"forward speed"}

"""Wilson's intervals, against published ones."""

from __future__ import annotations

import pytest

from docs.studies.intervals import wilson


def test_intervals_are_wilsons() -> None:
    # Newcombe (1998), Statistics in Medicine 17, 857-872, table I, method 3
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=5e-5)
    assert wilson(15, 148) == pytest.approx((0.0624, 0.1605), abs=5e-5)
    assert wilson(0, 20) == pytest.approx((0.0, 0.1611), abs=5e-5)
    assert wilson(1, 29) == pytest.approx((0.0061, 0.1718), abs=5e-5)


def test_wilson_intervals_are_the_textbooks() -> None:
    assert wilson(95, 100) == pytest.approx((0.8882, 0.9785), abs=1e-3)
    assert wilson(0, 100) == pytest.approx((0.0, 0.0370), abs=1e-3)


def test_no_trial_says_nothing_of_a_rate() -> None:
    assert wilson(0, 0) == (0.0, 1.0)

"""Forward selection names what acts, once and no more, whatever the likelihood is of: here of columns that explain a number."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import pytest

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.selection.cross_validation import cross_validated_gain
from swarm_envs.calibration.selection.forward import ForwardSelection, Rules, Selected, p_value
from swarm_envs.calibration.selection.likelihood import Fitted, Trial
from swarm_envs.calibration.selection.line_search import line_search
from swarm_envs.calibration.selection.profile import profile_likelihood_bound

Slopes = dict[str, float]


@dataclass
class Regression:
    """The likelihood of numbers under linear models of some columns, with noise of one."""

    columns: dict[str, FloatArray]
    numbers_seen: FloatArray
    minimum: float = 0.0
    held_out: dict[str, float] = field(default_factory=dict)
    alike: dict[str, tuple[str, ...]] = field(default_factory=dict)
    negligible: tuple[str, ...] = ()

    def fit(self, names: Sequence[str]) -> Fitted[Slopes]:
        design = np.column_stack([self.columns[name] for name in names]) if names else np.empty((len(self.numbers_seen), 0))
        slopes = np.linalg.lstsq(design, self.numbers_seen, rcond=None)[0]
        return Fitted(dict(zip(names, slopes, strict=True)), -0.5 * float(np.sum((self.numbers_seen - design @ slopes) ** 2)))

    @property
    def candidates(self) -> Sequence[str]:
        return tuple(self.columns)

    def confounded_with(self, name: str) -> Sequence[str]:
        return self.alike.get(name, ())

    def numbers(self, name: str) -> int:
        return 1

    def propose(self, fit: Fitted[Slopes], named: Sequence[str], candidates: Sequence[str]) -> list[Trial[Slopes]]:
        fits = {name: self.fit([*named, name]) for name in candidates}
        return [Trial(name, found.model, found.log_likelihood - fit.log_likelihood) for name, found in fits.items()]

    def refit(self, model: Slopes, named: Sequence[str]) -> Fitted[Slopes]:
        return self.fit(named)

    def without(self, fit: Fitted[Slopes], others: Sequence[str], name: str) -> Fitted[Slopes]:
        return self.fit(others)

    def overdispersion(self, fit: Fitted[Slopes], trial: Trial[Slopes]) -> float:
        return 1.0

    def is_large_enough(self, fit: Fitted[Slopes], trial: Trial[Slopes]) -> bool:
        return abs(trial.model[trial.name]) > self.minimum

    def is_negligible(self, fit: Fitted[Slopes], name: str) -> bool:
        return name in self.negligible

    def heldout_gain(self, fit: Fitted[Slopes], named: Sequence[str], trial: Trial[Slopes]) -> float:
        return self.held_out.get(trial.name, 1.0)


def columns(*names: str) -> dict[str, FloatArray]:
    generator = np.random.default_rng(3)
    return {name: generator.normal(size=200) for name in names}


def noise() -> FloatArray:
    return np.random.default_rng(4).normal(size=200)


def select(likelihood: Regression, rules: Rules | None = None, named: Sequence[str] = ()) -> Selected[Fitted[Slopes]]:
    rules = rules or Rules(most=6, examined=3, tried=len(likelihood.columns))
    selection = ForwardSelection[Slopes, Fitted[Slopes]](likelihood, likelihood.fit(named), rules, lambda text: None, [*named])
    return selection.run()


def test_exactly_the_columns_that_act_are_named_the_strongest_first() -> None:
    given = columns("a", "b", "c", "d")
    found = select(Regression(given, 0.6 * given["a"] - 1.5 * given["b"] + noise()))
    assert list(found.evidence) == ["b", "a"]
    assert found.fit.model == pytest.approx({"b": -1.5, "a": 0.6}, abs=0.2)
    assert {name for name, p in found.rejected if p > 0.01} == {"c", "d"}


def test_an_effect_that_later_ones_make_needless_is_dropped_unless_it_is_kept() -> None:
    given = columns("a", "b")
    mixture = given["a"] + given["b"]
    likelihood = Regression({"mixture": mixture + 0.3 * columns("x", "y", "z")["z"], **given}, 2.0 * mixture + noise())
    assert set(select(likelihood).evidence) == {"a", "b"}
    rules = Rules(most=6, examined=3, tried=3, kept=frozenset({"mixture"}))
    assert set(select(likelihood, rules).evidence) == {"mixture", "a", "b"}
    assert set(select(likelihood, Rules(most=6, examined=3, tried=3, eliminates=False)).evidence) == {"mixture", "a", "b"}


def test_candidates_that_explain_as_much_are_called_confounded() -> None:
    given = columns("a", "b")
    twin = given["a"] + 1e-3 * given["b"]
    found = select(Regression({"a": given["a"], "twin": twin, "b": given["b"]}, given["a"] + noise()))
    ((first, second),) = found.confounded
    assert {first, second} == {"a", "twin"}
    assert list(found.evidence) == [first]


def test_effects_that_are_alike_by_nature_exclude_each_other_and_are_called_confounded() -> None:
    given = columns("a", "b")
    likelihood = Regression(given, given["a"] + given["b"] + noise(), alike={"a": ("b",), "b": ("a",)})
    found = select(likelihood)
    (name,) = found.evidence
    assert found.confounded == ((name, *likelihood.alike[name]),)


def test_an_effect_below_its_minimum_size_is_not_named_however_certain_it_is() -> None:
    given = columns("a")
    assert list(select(Regression(given, given["a"] + noise(), minimum=0.5)).evidence) == ["a"]
    assert list(select(Regression(given, given["a"] + noise(), minimum=2.0)).evidence) == []


def test_an_effect_that_held_out_runs_do_not_bear_out_is_passed_over_for_the_next_that_is_examined() -> None:
    given = columns("a", "b")
    likelihood = Regression(given, 2.0 * given["a"] + given["b"] + noise(), held_out={"a": -1.0})
    assert list(select(likelihood).evidence) == ["b"]
    assert list(select(likelihood, Rules(most=6, examined=1, tried=2)).evidence) == []


def test_no_more_effects_are_named_than_asked_for() -> None:
    given = columns("a", "b", "c")
    likelihood = Regression(given, sum(given.values(), noise()))
    assert len(select(likelihood, Rules(most=2, examined=3, tried=3)).evidence) == 2


def test_an_effect_that_is_dropped_as_soon_as_it_is_named_is_not_named_for_ever() -> None:
    given = columns("a", "b")
    found = select(Regression(given, given["a"] + given["b"] + noise(), negligible=("a",)))
    assert list(found.evidence) == ["b"]


def test_what_the_first_fit_has_is_named_without_evidence() -> None:
    given = columns("a", "b")
    found = select(Regression(given, given["a"] + given["b"] + noise()), named=["a"])
    assert list(found.evidence) == ["a", "b"]
    assert np.isnan(found.evidence["a"].heldout_gain)
    assert found.evidence["b"].heldout_gain == 1.0


def test_p_values_are_corrected_for_the_number_tried_and_for_overdispersion() -> None:
    # chi-squared with one degree of freedom exceeds 3.84 one time in twenty
    assert p_value(1.9207, 1, 1) == pytest.approx(0.05, abs=1e-4)
    assert p_value(1.9207, 1, 4) == pytest.approx(0.2, abs=1e-3)
    assert p_value(1.9207 * 3, 1, 1, overdispersion=3.0) == pytest.approx(0.05, abs=1e-4)
    assert p_value(-5.0, 2, 10) == 1.0


def test_bounds_of_a_parabola_are_two_standard_deviations_away() -> None:
    def drop(value: float) -> float:
        return 0.5 * ((value - 3.0) / 0.1) ** 2

    assert profile_likelihood_bound(drop, 3.0, 0.0) == pytest.approx(3.0 - 0.196, abs=0.003)
    assert profile_likelihood_bound(drop, 3.0, 4.0) == pytest.approx(3.0 + 0.196, abs=0.003)
    assert profile_likelihood_bound(drop, 3.0, 3.1) == pytest.approx(3.1, abs=1e-3)


def test_each_group_is_held_out_once_from_what_is_fitted_to() -> None:
    seen: list[int] = []

    def gained(train: list[int], test: list[int]) -> float:
        assert sorted(train + test) == list(range(7))
        seen.extend(test)
        return float(len(test))

    assert cross_validated_gain(7, 3, gained) == 7.0
    assert sorted(seen) == list(range(7))


def test_a_line_search_keeps_what_it_cannot_better() -> None:
    assert line_search(lambda x: -((x - 1.0) ** 2), 0.0, -1.0, (-2.0, 2.0), 1e-6)[0] == pytest.approx(1.0, abs=1e-4)
    assert line_search(lambda x: -((x - 1.0) ** 2), 1.0, 0.0, (-2.0, 0.5), 1e-6) == (1.0, 0.0)

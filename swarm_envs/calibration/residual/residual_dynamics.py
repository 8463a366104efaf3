"""Residual dynamics, ``unlisted`` in findings.json: what no listed effect explains, as a function of what it depends on.

Velocities are corrected by ``regressor * g(z)``: the regressor says whether the correction grows with the speed, ``g`` is a smooth function
of the covariate ``z`` or, over the arena, one of two levels with an edge between them. Regressor, covariate and stiffness
are those that predict held-out runs best.

Listed effects may make up for what is on no list, as a smaller gain and robots that differ do for a slippery patch. So corrections are
weighed against named effects, too: by how well either predicts held-out runs from their commands alone.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.drive.candidates import BY_NAME
from swarm_envs.calibration.drive.fitting import Model
from swarm_envs.calibration.drive.identification import Identified
from swarm_envs.calibration.drive.noise import HEADING, PLACE
from swarm_envs.calibration.logs.log import Log
from swarm_envs.calibration.prediction.windows import rms
from swarm_envs.calibration.residual.corrected_prediction import Errors, heldout_errors
from swarm_envs.calibration.residual.corrections import PLANE, REGRESSORS, Term, covariates_of
from swarm_envs.calibration.residual.criticism import Discrepancy
from swarm_envs.calibration.residual.fit_piecewise_floor import Floor, fit_piecewise_floor
from swarm_envs.calibration.residual.residuals import CHANNELS, Residuals, held_out_together, residuals, winsorised
from swarm_envs.calibration.residual.smoothing import Smooth, sign_flip_p_value, smooth_corrections

LEAST_GAIN = 10.0
"""Gain in log-likelihood of held-out windows, in nats, without which a channel is not corrected."""
SIGNIFICANT = 0.005
"""Greatest p-value at which a remainder is reported."""
AS_GOOD = 3.0
"""A named effect goes when corrections without it fit as well but for this much, in nats."""
BETTER = 0.97
"""Or when held-out errors are then at most this share of what they were."""
CLEARLY = 0.85
"""Where nothing certain is left beside the named effects, corrections must bring errors to this share to take their place."""
TIMING = ("dead_time", "clock_offset", "motor_lag")
"""Effects that never go: windows of half a second show little of them, and no function of place or heading mimics them."""
SLOWING = (
    "linear_gain", "angular_gain", "robot_spread", "command_loss", "gain_drift", "turning_slows", "saturation", "deadband",
)  # fmt: skip
"""Effects that make up for places or times at which robots are slower."""
AT_THE_FLOOR = 1.2
"""Errors after the shortest horizon up to this multiple of what the tracker's noise makes leave nothing to correct."""
ENOUGH = 40
"""Windows without which nothing is said."""
WORTH = 0.1
"""Residual dynamics are reported when their correction lowers a held-out error by at least this share."""
PLAINER = 0.85
"""A simpler covariate is preferred when it gains at least this share of the best one's gain."""
EDGES = 0.5
"""A floor of two kinds is tried where a smooth function of place gains this share of the best."""
FLIPS = 1999
"""Random signs given to blocks of windows when two models are compared."""


@dataclass(frozen=True)
class HeldOut:
    """Error at a horizon on held-out runs."""

    horizon_s: float
    position_world: float
    """rms in m of the world as it was."""
    position_before: float
    """With the named effects alone, fitted to other runs."""
    position_after: float
    """With the corrections, fitted to other runs."""
    heading_world: float
    """rms in rad."""
    heading_before: float
    heading_after: float


@dataclass(frozen=True)
class ResidualDynamics:
    """What no listed effect explains."""

    discrepancy: Discrepancy
    """Channel, covariate and size of the largest correction; p-value of there being any remainder."""
    terms: tuple[Term, ...]
    """The corrections, the largest first."""
    heldout: tuple[HeldOut, ...]
    """How much better runs are predicted that the corrections were not fitted to."""
    model: Model
    """The drive that is corrected: the named effects without those in :attr:`instead_of`."""
    instead_of: tuple[str, ...]
    """Effects that had been named and that the corrections make needless."""

    def remaining(self, identified: Identified) -> Identified:
        """Return what was identified without the effects that the corrections make needless."""

        def leave_out() -> tuple[Model, ...]:
            # models of one fold stay one
            plain = {id(model): _without(model, self.instead_of, identified.start) for model in identified.without}
            return tuple(plain[id(model)] for model in identified.without)

        causes = tuple(cause for cause in identified.causes if cause.effect not in self.instead_of)
        return dataclasses.replace(identified, causes=causes, model=self.model, leave_out=leave_out)

    def to_document(self) -> dict[str, Any]:
        """Return what ``findings.json`` holds: each correction as a table, and the held-out errors."""
        return {
            "effect": "unlisted",
            "instead_of": list(self.instead_of),
            "terms": [term.to_document() for term in self.terms],
            "heldout": [dataclasses.asdict(entry) for entry in self.heldout],
        }


@dataclass(frozen=True)
class _Extended:
    """A drive with the corrections that predict held-out windows best."""

    model: Model
    found: Residuals
    trials: tuple[Smooth, ...]
    terms: tuple[Term, ...]
    merit: float
    """Log-likelihood of held-out windows, up to a constant."""
    errors: tuple[Errors, ...]


def find_residual_dynamics(log: Log, identified: Identified) -> ResidualDynamics | None:
    """Model what a drive leaves unexplained, if that is certain and worth it.

    Named effects that only made up for the remainder, as a smaller gain does for a slippery patch, go.

    Args:
        log: The log.
        identified: Its named effects.

    Returns:
        None when no remainder is certain, or correcting it does not predict held-out runs better.
    """
    robots = identified.robots
    found = residuals(log, identified.model, robots)
    if len(found.errors) < ENOUGH or int(found.group.max()) < 1:
        return None
    groups = int(found.group.max()) + 1
    others = _fitted_to_others(log, identified, groups)
    listed = heldout_errors(log, others, robots)

    def extended(gone: Sequence[str]) -> _Extended:
        return _extend(log, _without(identified.model, gone, identified.start), robots, groups)

    kept = TIMING + ("linear_gain", "angular_gain") * identified.gains_first
    names = [cause.effect for cause in identified.causes if cause.effect not in kept]
    trials = smooth_corrections(found)
    p_value = sign_flip_p_value(trials, found) if _best_gain(trials) > LEAST_GAIN else 1.0
    gone: list[str] = []
    if p_value <= SIGNIFICANT:
        best = extended(())
        for group in [names, *([name] for name in names)]:
            if set(group) <= set(gone):
                continue
            other = extended([*gone, *group])
            if other.merit > best.merit - AS_GOOD or _is_better(other.errors, best.errors):
                best, gone = other, [*gone, *group]
    else:
        instead = None
        if names and not _at_the_floor(found, identified.model, listed):
            instead = _in_place_of_listed(names, listed, extended)
        if instead is None:
            return None
        best, gone, p_value = instead
    after = [_without(model, gone, identified.start) for model in others]
    world = heldout_errors(log, [identified.start] * groups, robots)
    heldout = _compared(world, listed, heldout_errors(log, after, robots, best.terms))
    if not best.terms or max((_improvement(entry) for entry in heldout), default=0.0) < WORTH:
        return None
    first = best.terms[0]
    channel = list(CHANNELS)[first.channel]
    size = rms(first(covariates_of(best.found)))
    departure = Discrepancy(channel, first.basis.depends_on, size, CHANNELS[channel], p_value)
    return ResidualDynamics(departure, best.terms, heldout, best.model, tuple(dict.fromkeys(gone)))


def _in_place_of_listed(
    names: Sequence[str], listed: Sequence[Errors], extended: Callable[[Sequence[str]], _Extended]
) -> tuple[_Extended, list[str], float] | None:
    """Return corrections that predict held-out runs clearly better than named effects, which then go; with the p-value.

    Both are fitted to other runs than those that they predict. Named effects are preferred: they stay unless they are clearly worse.
    """
    groups = [list(names), [name for name in names if name in SLOWING]]
    groups = [group for number, group in enumerate(groups) if group and group not in groups[:number]]
    for group in groups:
        other = extended(group)
        p_value = min(1.0, len(groups) * _p_value_of_better(other.errors, listed))
        if other.terms and p_value <= SIGNIFICANT and _is_clearly_better(other.errors, listed):
            return other, group, p_value
    return None


def _fitted_to_others(log: Log, identified: Identified, groups: int) -> list[Model]:
    """Return for each held-out group the named effects as other runs have them; where runs are few and in parts, as all runs have them."""
    whole = tuple(run for run, part in held_out_together(log) if part < 0) == identified.data.runs
    return list(identified.without) if whole and identified.causes else [identified.model] * groups


def _extend(log: Log, model: Model, robots: tuple[str, ...], groups: int) -> _Extended:
    """Correct a drive."""
    found = residuals(log, model, robots)
    trials = smooth_corrections(found)
    floors = _floors(trials, found)
    terms, merit = _chosen(trials, floors, found), 0.0
    for channel in REGRESSORS:
        squares = float(np.sum(winsorised(found.errors[:, channel]) ** 2))
        merit += max(0.0, _best_gain(trials, channel), floors[channel].gain if channel in floors else 0.0)
        merit -= 0.5 * len(found.errors) * float(np.log(squares))
    return _Extended(model, found, tuple(trials), terms, merit, heldout_errors(log, [model] * groups, robots, terms))


def _best_gain(trials: Sequence[Smooth], channel: int | None = None, depends_on: str | None = None) -> float:
    """Return the largest gain of the corrections of a channel, by a covariate."""
    gains = (t.gain for t in trials if channel in (None, t.channel) and depends_on in (None, t.basis.depends_on))
    return max(gains, default=0.0)


def _floors(trials: Sequence[Smooth], found: Residuals) -> dict[int, Floor]:
    """Return by channel a floor of two kinds, where place matters."""
    floors = {}
    for channel in REGRESSORS:
        gain = _best_gain(trials, channel, PLANE)
        if gain > max(LEAST_GAIN, EDGES * _best_gain(trials, channel)):
            smooth = next(t for t in trials if t.channel == channel and t.basis.depends_on == PLANE and t.gain == gain)
            floors[channel] = fit_piecewise_floor(smooth, found)
    return floors


def _chosen(trials: Sequence[Smooth], floors: Mapping[int, Floor], found: Residuals) -> tuple[Term, ...]:
    """Return for each channel the correction that predicts held-out windows best, the one with the largest gain first."""
    chosen: list[tuple[float, Term]] = []
    for channel in REGRESSORS:
        floor = floors.get(channel)
        best = max(_best_gain(trials, channel), 0.0 if floor is None else floor.gain)
        if best <= LEAST_GAIN:
            continue
        # the simplest covariates were tried first
        plain = (t.basis.depends_on for t in trials if t.channel == channel and t.gain >= PLAINER * best)
        name = next(plain, PLANE)
        gain = _best_gain(trials, channel, name)
        if floor is not None and name == PLANE and floor.gain > gain:
            chosen.append((floor.gain, floor.term))
        else:
            trial = next(t for t in trials if t.channel == channel and t.basis.depends_on == name and t.gain == gain)
            chosen.append((gain, trial.term(found)))
    return tuple(term for _, term in sorted(chosen, key=lambda entry: -entry[0]))


# comparing models


def _compared(world: Sequence[Errors], before: Sequence[Errors], after: Sequence[Errors]) -> tuple[HeldOut, ...]:
    rows = []
    for errors in zip(world, before, after, strict=True):
        place, heading = zip(*(entry.sizes for entry in errors), strict=True)
        rows.append(HeldOut(errors[0].horizon_s, *place, *heading))
    return tuple(rows)


def _ratios(these: Sequence[Errors], those: Sequence[Errors]) -> tuple[float, float]:
    """Return the geometric means of the ratios of two models' held-out errors, of place and of heading."""
    ratios = np.array([np.log(np.divide(a.sizes, b.sizes)) for a, b in zip(these, those, strict=True)])
    place, heading = np.exp(ratios.mean(axis=0)) if len(ratios) else (1.0, 1.0)
    return float(place), float(heading)


def _is_better(these: Sequence[Errors], those: Sequence[Errors]) -> bool:
    """Whether held-out errors are smaller, all in all."""
    place, heading = _ratios(these, those)
    return place * heading < BETTER**2


def _is_clearly_better(these: Sequence[Errors], those: Sequence[Errors]) -> bool:
    """Whether held-out errors of place or of heading are clearly smaller, and those of the other are no larger."""
    better, other = sorted(_ratios(these, those))
    return better < CLEARLY and other < 2.0 - BETTER


def _p_value_of_better(these: Sequence[Errors], those: Sequence[Errors]) -> float:
    """Return the p-value of a model's errors after the shortest horizon being no smaller than another's.

    Windows' log-likelihoods are compared, each model's errors having their own variance; blocks of windows get random signs.
    """
    if not these:
        return 1.0
    gained = _log_likelihood(these[0]) - _log_likelihood(those[0])
    blocks = np.bincount(these[0].block, gained)
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (FLIPS, len(blocks)))
    return float((1 + np.sum(signs @ blocks >= blocks.sum())) / (1 + FLIPS))


def _log_likelihood(errors: Errors) -> FloatArray:
    """Return the log-likelihood (W,) of windows, up to a constant; wild ones do not decide."""
    total = np.zeros(len(errors.place))
    for values, directions in ((errors.place, 2.0), (errors.heading, 1.0)):
        limited = winsorised(values)
        variance = float(np.mean(limited**2)) / directions + 1e-12
        total -= 0.5 * (limited**2 / variance + directions * np.log(variance))
    return total


def _at_the_floor(found: Residuals, model: Model, errors: Sequence[Errors]) -> bool:
    """Whether errors after the shortest horizon are what the tracker's noise makes of them."""
    if not errors:
        return True
    place, heading = errors[0].sizes
    noise, turned = float(model.noise[PLACE]), float(model.noise[HEADING])
    way = errors[0].horizon_s * rms(found.motion[:, 0])
    floors = float(np.hypot(2.0 * noise, turned * way)), float(np.sqrt(2.0)) * turned
    return place < AT_THE_FLOOR * floors[0] and heading < AT_THE_FLOOR * floors[1]


def _without(model: Model, names: Sequence[str], start: Model) -> Model:
    """Return a model with some effects as the world has them."""
    parameters, gains = model.parameters.copy(), model.gains
    for name in names:
        if name == "robot_spread":
            gains = np.ones_like(gains)
        else:
            for parameter in BY_NAME[name].parameters:
                parameters[parameter.index] = start.parameters[parameter.index]
    return dataclasses.replace(model, parameters=parameters, gains=gains)


def _improvement(entry: HeldOut) -> float:
    """Return the share by which the error falls, of place or heading, whichever gains more."""
    return max(1.0 - entry.position_after / entry.position_before, 1.0 - entry.heading_after / entry.heading_before)

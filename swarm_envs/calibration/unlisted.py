"""Effect ``unlisted``: what no listed effect explains, as a smooth function of what it depends on.

Velocities are corrected by ``carrier * g(z)``: the carrier says whether the correction grows with the speed, ``g`` is a ridge
regression on radial basis functions of the circumstance ``z``. Carrier, circumstance and penalty are those that predict runs best
that were held out.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from swarm_envs.calibration.candidates import BY_NAME
from swarm_envs.calibration.criticism import (
    CHANNELS,
    Discrepancy,
    Residuals,
    group_of,
    held_out_together,
    residuals,
    situation,
    tamed,
)
from swarm_envs.calibration.drive import IntArray, free_run
from swarm_envs.calibration.fitting import Model
from swarm_envs.calibration.identification import Identified
from swarm_envs.calibration.log import FloatArray, Log, Track
from swarm_envs.calibration.prediction import HORIZONS, rms, tracked, windows

FORWARD, LATERAL, TURN = range(3)
CARRIERS = {
    FORWARD: ("speed", "any motion"),
    LATERAL: ("speed", "turn rate", "any motion"),
    TURN: ("distance", "speed", "turn rate", "any motion"),
}
"""What the corrections of a channel may be proportional to: forward speed, its amount, turn rate, or nothing."""
CIRCUMSTANCES = ("heading", "commanded speed", "commanded turn rate", "time since a start", "time in the run", "robot", "place")
"""What a correction may depend on, simplest first."""
PERIODIC, ONE_BY_ONE, PLANE = "heading", "robot", "place"
SPACING = 0.08
"""Least distance in m of the basis functions over the arena."""
MOST = 200
"""Basis functions over the arena at most."""
WIDTHS = (0.2, 0.6)
"""Lengths in m over which a correction may change over the arena."""
ALONG = 9
"""Basis functions along a number."""
PENALTIES = np.geomspace(1e-3, 1e3, 13)
"""Ridge penalties tried."""
FOLDS = 6
"""Parts of the runs, each held out once."""
LEAST_GAIN = 10.0
"""Gain in log-likelihood of held-out windows, in nats, without which a channel is not corrected."""
RESAMPLES = 499
"""Random signs given to the blocks of windows."""
SIGNIFICANT = 0.005
"""Greatest p-value at which a remainder is reported."""
AS_GOOD = 3.0
"""A named effect goes when corrections without it fit as well but for this much, in nats."""
TIMING = ("dead_time", "clock_offset", "motor_lag")
"""Effects that never go: windows of half a second show little of them, and no function of place or heading feigns them."""
BETTER = 0.97
"""Or when held-out errors are then at most this share of what they were."""
ENOUGH = 40
"""Windows without which nothing is said."""
STEP = 0.05
"""Step in s with which corrected motion is integrated."""
WORTH = 0.1
"""A remainder is reported when its correction takes away at least this share of a held-out error."""
PLAINER = 0.85
"""A simpler circumstance is preferred when it gains at least this share of the best one's gain."""


@dataclass(frozen=True)
class Basis:
    """Functions of a circumstance whose ridge regression is that of a Gaussian process, and a constant."""

    depends_on: str
    centres: FloatArray
    """(M, D) in the circumstance's coordinates: m over the arena, a unit circle for headings, else s, m/s or rad/s."""
    width: float
    """Length over which the function changes, in the same."""
    mixed: FloatArray
    """(M, M) makes kernels at the centres into functions that are as likely as each other."""

    def __call__(self, coordinates: FloatArray) -> FloatArray:
        """Return the functions' values (W, M + 1) at coordinates (W, D)."""
        return np.column_stack([_kernel(coordinates, self.centres, self.width, self.depends_on) @ self.mixed, np.ones(len(coordinates))])

    @classmethod
    def at(cls, depends_on: str, centres: FloatArray, width: float) -> Basis:
        """Return the basis with these centres."""
        values, vectors = np.linalg.eigh(_kernel(centres, centres, width, depends_on))
        return cls(depends_on, centres, width, vectors / np.sqrt(np.maximum(values, 1e-6 * values.max())))


def _kernel(coordinates: FloatArray, centres: FloatArray, width: float, depends_on: str) -> FloatArray:
    """Return how alike the function is at coordinates (W, D) and centres (M, D): (W, M)."""
    squared = (coordinates**2).sum(axis=1)[:, None] + (centres**2).sum(axis=1) - 2.0 * coordinates @ centres.T
    squared = np.maximum(squared, 0.0) / width**2
    # floors have edges
    return np.asarray(np.exp(-np.sqrt(squared)) if depends_on == PLANE else np.exp(-0.5 * squared))


@dataclass(frozen=True)
class Term:
    """One correction: ``carrier * basis(z) @ weights`` is added to a channel."""

    channel: int
    carrier: str
    basis: Basis
    weights: FloatArray
    """(M + 1,) fitted to all runs."""
    without: FloatArray
    """(G, M + 1) for each held-out group those fitted without its fold."""

    def __call__(self, at: Circumstances, weights: FloatArray | None = None) -> FloatArray:
        """Return the correction (W,) of the channel in m/s or rad/s; ``weights`` (W, M + 1) if each has its own."""
        values = self.basis(at.coordinates(self.basis.depends_on))
        given = values @ self.weights if weights is None else np.einsum("wm,wm->w", values, weights)
        return np.asarray(at.carrier(self.carrier) * given)


@dataclass(frozen=True)
class Circumstances:
    """Where W robots are, how they move and what they were told."""

    pose: FloatArray
    """(W, 3) m, m, rad: the robot's heading, not the marker's."""
    motion: FloatArray
    """(W, 2) forward speed in m/s and turn rate in rad/s, as the listed effects have them."""
    command: FloatArray
    """(W, 2) in force."""
    since: FloatArray
    """(W,) s since the last start from rest."""
    time: FloatArray
    """(W,) s since the start of the run."""
    robot: FloatArray
    """(W,) index."""

    def coordinates(self, name: str) -> FloatArray:
        """Return the coordinates (W, D) of a circumstance."""
        if name == "place":
            return self.pose[:, :2]
        if name == "heading":
            return np.column_stack([np.cos(self.pose[:, 2]), np.sin(self.pose[:, 2])])
        values = {
            "commanded speed": self.command[:, 0], "commanded turn rate": self.command[:, 1], "time since a start": self.since,
            "time in the run": self.time, "robot": self.robot,
        }  # fmt: skip
        return np.asarray(values[name][:, None], float)

    def carrier(self, name: str) -> FloatArray:
        """Return what a correction is proportional to (W,)."""
        v, omega = self.motion.T
        if name == "any motion":
            return np.asarray((np.abs(v) > 1e-3) | (np.abs(omega) > 1e-2), float)
        return np.asarray({"speed": v, "distance": np.abs(v), "turn rate": omega}[name])


@dataclass(frozen=True)
class HeldOut:
    """Error at a horizon on held-out runs."""

    horizon_s: float
    position_before: float
    """rms in m with the listed effects alone."""
    position_after: float
    heading_before: float
    """rms in rad."""
    heading_after: float


@dataclass(frozen=True)
class Unlisted:
    """What no listed effect explains."""

    discrepancy: Discrepancy
    """Channel, circumstance and size of the largest correction; p-value of there being any remainder."""
    terms: tuple[Term, ...]
    """The corrections, the largest first."""
    heldout: tuple[HeldOut, ...]
    """How much better runs are predicted that the corrections were not fitted to."""
    model: Model
    """The drive that is corrected: the named effects without those in :attr:`instead_of`."""
    instead_of: tuple[str, ...]
    """Effects that had been named and that the corrections make needless."""

    def correct(self, at: Circumstances) -> FloatArray:
        """Return the corrections (W, 3) of forward speed and lateral slip in m/s and of turn rate in rad/s."""
        return _corrections(self.terms, at, None)

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
            "terms": [_table(term) for term in self.terms],
            "heldout": [dataclasses.asdict(entry) for entry in self.heldout],
        }


def find_unlisted(log: Log, identified: Identified) -> Unlisted | None:
    """Model what a drive leaves unexplained, if that is certain and worth it.

    Named effects that only made up for the remainder, as a smaller gain does for a slippery patch, go.

    Args:
        log: The log.
        identified: Its named effects.

    Returns:
        None when no remainder is certain, or correcting it does not predict held-out runs better.
    """
    model, robots = identified.model, identified.robots
    found = residuals(log, model, robots)
    if len(found.errors) < ENOUGH or int(found.group.max()) < 1:
        return None
    trials = _trials(found)
    if not _chosen(trials, found):
        return None
    p_value = _p_value(trials, found)
    if p_value > SIGNIFICANT:
        return None
    kept = TIMING + ("linear_gain", "angular_gain") * identified.gains_first
    names = [cause.effect for cause in identified.causes if cause.effect not in kept]
    merit, terms = _merit(trials, found), _chosen(trials, found)
    heldout = heldout_errors(log, model, model, robots, terms)
    gone: list[str] = []
    for group in [names, *([name] for name in names)]:
        if set(group) <= set(gone):
            continue
        simpler = _without(model, group, identified.start)
        left = residuals(log, simpler, robots)
        tried = _trials(left)
        other = _chosen(tried, left)
        reached = heldout_errors(log, identified.model, simpler, robots, other)
        if _merit(tried, left) > merit - AS_GOOD or _ratio(reached, heldout) < BETTER:
            model, found, terms, heldout, merit = simpler, left, other, reached, _merit(tried, left)
            gone += group
    if not terms or max((_cut(entry) for entry in heldout), default=0.0) < WORTH:
        return None
    channel = list(CHANNELS)[terms[0].channel]
    size = rms(terms[0](circumstances_of(found)))
    return Unlisted(
        Discrepancy(channel, terms[0].basis.depends_on, size, CHANNELS[channel], p_value), terms, heldout, model, tuple(dict.fromkeys(gone))
    )


def _ratio(these: Sequence[HeldOut], those: Sequence[HeldOut]) -> float:
    """Return the geometric mean of the ratios of two models' held-out errors."""
    ratios = [(a.position_after / b.position_after) * (a.heading_after / b.heading_after) for a, b in zip(these, those, strict=True)]
    return float(np.exp(0.5 * np.mean(np.log(ratios))))


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


def _merit(trials: Sequence[_Trial], found: Residuals) -> float:
    """Return the log-likelihood of held-out windows with the best corrections, up to a constant."""
    total = 0.0
    for channel in CARRIERS:
        squares = float(np.sum(tamed(found.errors[:, channel]) ** 2))
        total -= 0.5 * len(found.errors) * float(np.log(squares))
        total += max(0.0, *(trial.gain for trial in trials if trial.channel == channel))
    return total


def _cut(entry: HeldOut) -> float:
    """Return the share of the error taken away, of place or heading, whichever gains more."""
    return max(1.0 - entry.position_after / entry.position_before, 1.0 - entry.heading_after / entry.heading_before)


# the fit


@dataclass(frozen=True)
class _Trial:
    """A correction that was tried on a channel."""

    channel: int
    carrier: str
    basis: Basis
    values: FloatArray
    """(W, M + 1) of its functions, times the carrier."""
    gain: float
    """In log-likelihood of held-out windows, in nats."""
    penalty: float


def _trials(found: Residuals) -> list[_Trial]:
    """Try every correction; the penalty of each is what predicts held-out windows best."""
    at = circumstances_of(found)
    trials = []
    for name in CIRCUMSTANCES:
        for basis in _bases(name, at):
            functions = basis(at.coordinates(name))
            for channel, carriers in CARRIERS.items():
                errors = tamed(found.errors[:, channel])
                for carrier in carriers:
                    values = functions * at.carrier(carrier)[:, None]
                    trials.append(_Trial(channel, carrier, basis, values, *_heldout_gain(values, errors, found.group)))
    return trials


def _chosen(trials: Sequence[_Trial], found: Residuals) -> tuple[Term, ...]:
    """Return for each channel the correction that predicts held-out windows best, the one with the largest gain first."""
    chosen: list[_Trial] = []
    for channel in CARRIERS:
        best = max((trial.gain for trial in trials if trial.channel == channel), default=0.0)
        if best > LEAST_GAIN:
            # the simplest circumstances were tried first
            name = next(trial.basis.depends_on for trial in trials if trial.channel == channel and trial.gain >= PLAINER * best)
            chosen.append(max((t for t in trials if t.channel == channel and t.basis.depends_on == name), key=lambda t: t.gain))
    chosen.sort(key=lambda trial: -trial.gain)
    terms = []
    for trial in chosen:
        errors = tamed(found.errors[:, trial.channel])
        terms.append(Term(trial.channel, trial.carrier, trial.basis, *_fitted(trial.values, errors, found.group, trial.penalty)))
    return tuple(terms)


def circumstances_of(found: Residuals) -> Circumstances:
    """Return the circumstances of windows."""
    c = found.circumstances
    return Circumstances(
        np.column_stack([found.where, c["heading"]]), found.motion, np.column_stack([c["commanded speed"], c["commanded turn rate"]]),
        c["time since a start"], c["time in the run"], c["robot"],
    )  # fmt: skip


def _bases(name: str, at: Circumstances) -> list[Basis]:
    """Return bases where the data are; none where a circumstance does not vary."""
    coordinates = at.coordinates(name)
    if name == ONE_BY_ONE:
        kinds = np.unique(coordinates)
        return [Basis.at(name, kinds[:, None], 0.1)] if len(kinds) > 1 else []
    if name == PERIODIC:
        angles = np.linspace(0, 2 * np.pi, 12, endpoint=False)
        return [Basis.at(name, np.column_stack([np.cos(angles), np.sin(angles)]), 0.7)]
    if name == PLANE:
        spacing = SPACING
        while len(cells := np.unique(np.floor(coordinates / spacing), axis=0)) > MOST:
            spacing *= 1.2
        return [Basis.at(name, (cells + 0.5) * spacing, width) for width in WIDTHS]
    low, high = np.quantile(coordinates, (0.01, 0.99))
    if high - low < 1e-6:
        return []
    return [Basis.at(name, np.linspace(low, high, ALONG)[:, None], 1.5 * (high - low) / (ALONG - 1))]


def _sums(values: FloatArray, errors: FloatArray, group: IntArray) -> tuple[FloatArray, FloatArray, FloatArray, int]:
    """Return normal equations of each fold: (F, M, M), (F, M), and sums of squares (F,); and the number of folds."""
    folds = min(FOLDS, int(group.max()) + 1)
    squares = np.empty((folds, values.shape[1], values.shape[1]))
    products, totals = np.empty((folds, values.shape[1])), np.empty(folds)
    for fold in range(folds):
        inside = group % folds == fold
        squares[fold], products[fold] = values[inside].T @ values[inside], values[inside].T @ errors[inside]
        totals[fold] = float(errors[inside] @ errors[inside])
    return squares, products, totals, folds


def _heldout_gain(values: FloatArray, errors: FloatArray, group: IntArray) -> tuple[float, float]:
    """Return the gain in log-likelihood of held-out windows over no correction, and the penalty with the most."""
    squares, products, totals, folds = _sums(values, errors, group)
    scale = float(np.trace(squares.sum(axis=0))) / values.shape[1]
    left = np.zeros(len(PENALTIES))
    for fold in range(folds):
        eigen, vectors = np.linalg.eigh(squares.sum(axis=0) - squares[fold])
        turned = vectors.T @ (products.sum(axis=0) - products[fold])
        for k, penalty in enumerate(PENALTIES):
            weights = vectors @ (turned / (np.maximum(eigen, 0.0) + penalty * scale))
            left[k] += totals[fold] - 2.0 * weights @ products[fold] + weights @ squares[fold] @ weights
    best = int(np.argmin(left))
    return 0.5 * len(errors) * float(np.log(totals.sum() / max(left[best], 1e-300))), float(PENALTIES[best]) * scale


def _fitted(values: FloatArray, errors: FloatArray, group: IntArray, penalty: float) -> tuple[FloatArray, FloatArray]:
    """Return the weights (M,) from all windows, and for each group (G, M) from the other folds' windows."""
    squares, products, _, folds = _sums(values, errors, group)
    ridge = penalty * np.eye(values.shape[1])
    every = np.linalg.solve(squares.sum(axis=0) + ridge, products.sum(axis=0))
    without = [np.linalg.solve(squares.sum(axis=0) - squares[f] + ridge, products.sum(axis=0) - products[f]) for f in range(folds)]
    return every, np.array([without[g % folds] for g in range(int(group.max()) + 1)])


def _p_value(trials: Sequence[_Trial], found: Residuals) -> float:
    """Return how often chance yields a gain as large as the largest.

    Errors get a random sign, one for each block of windows, which leaves alike what errs alike; the corrections of each draw are
    fitted and held against held-out windows as the real ones were.
    """
    signs = np.random.default_rng(0).choice([-1.0, 1.0], (int(found.block.max()) + 1, RESAMPLES))
    chance = np.zeros(RESAMPLES)
    for trial in trials:
        errors = tamed(found.errors[:, trial.channel])
        squares, _, totals, folds = _sums(trial.values, errors, found.group)
        signed = np.empty((folds, trial.values.shape[1], RESAMPLES))
        for fold in range(folds):
            inside = found.group % folds == fold
            sums = np.zeros((len(signs), trial.values.shape[1]))
            np.add.at(sums, found.block[inside], trial.values[inside] * errors[inside, None])
            signed[fold] = sums.T @ signs
        for stiffer in (1.0, 30.0):
            left = np.full(RESAMPLES, totals.sum())
            for fold in range(folds):
                ridge = squares.sum(axis=0) - squares[fold] + stiffer * trial.penalty * np.eye(len(signed[fold]))
                weights = np.linalg.solve(ridge, signed.sum(axis=0) - signed[fold])
                left += np.einsum("ms,ms->s", weights, squares[fold] @ weights - 2.0 * signed[fold])
            chance = np.maximum(chance, 0.5 * len(errors) * np.log(totals.sum() / np.maximum(left, 1e-300)))
    largest = max(trial.gain for trial in trials)
    return float((1 + np.sum(chance >= largest)) / (1 + RESAMPLES))


# what it does to predictions


def _corrections(terms: Sequence[Term], at: Circumstances, group: IntArray | None) -> FloatArray:
    result = np.zeros((len(at.time), len(CHANNELS)))
    for term in terms:
        result[:, term.channel] += term(at, None if group is None else term.without[group])
    return result


def heldout_errors(log: Log, before: Model, after: Model, robots: tuple[str, ...], terms: Sequence[Term]) -> tuple[HeldOut, ...]:
    """Return free-running errors on held-out runs with the listed effects alone and with corrections fitted to other runs.

    Both start from a measured pose and see nothing but the commands; corrections are taken along the predicted path.
    """
    groups = held_out_together(log)
    rows = []
    for horizon in HORIZONS:
        errors: list[FloatArray] = []
        for track in tracked(log):
            robot = robots.index(track.robot)
            first, last = windows(track.times, horizon)
            if not len(first):
                continue
            group = np.array([group_of(groups, track, float(t)) for t in track.times[first]], np.int64)
            both = [predict(model, track, robot, first, last, used, group) for model, used in ((before, ()), (after, terms))]
            errors.append(np.stack([_missed(path, track.poses[last]) for path in both]))
        if errors:
            (place, heading), (place_after, heading_after) = np.concatenate(errors, axis=1).transpose(0, 2, 1)
            rows.append(HeldOut(horizon, rms(place), rms(place_after), rms(heading), rms(heading_after)))
    return tuple(rows)


def _missed(predicted: FloatArray, measured: FloatArray) -> FloatArray:
    turned = (predicted[:, 2] - measured[:, 2] + np.pi) % (2 * np.pi) - np.pi
    return np.column_stack([np.hypot(*(predicted[:, :2] - measured[:, :2]).T), turned])


def predict(
    model: Model, track: Track, robot: int, first: IntArray, last: IntArray, terms: Sequence[Term], group: IntArray | None = None
) -> FloatArray:
    """Return the measured poses (W, 3) predicted at the ends of windows, corrections included.

    Args:
        model: The drive.
        track: The track.
        robot: Index of its robot.
        first: (W,) indices of the poses that windows start from.
        last: (W,) indices of those that they end at.
        terms: The corrections.
        group: (W,) the held-out group of each window, for corrections fitted without it; None for those fitted to all.
    """
    gain, yaw = model.gains[robot], float(model.parameters[-2])
    begin, end = track.times[first], track.times[last]
    fine = np.arange(begin.min(), end.max() + 0.02, 0.02)
    run = free_run(model.parameters, dataclasses.replace(track, times=fine), gain)
    steps = max(1, int(np.ceil(float((end - begin).max()) / STEP)))
    pose = track.poses[first] - np.array([0.0, 0.0, yaw])
    dt = (end - begin) / steps
    now = _at(begin, fine, run.path, run.drift)
    for step in range(steps):
        then = _at(begin + (step + 1) * dt, fine, run.path, run.drift)
        turned = then[:, 2] - now[:, 2]
        middle = 0.5 * (then[:, 2] + now[:, 2])
        gone = then[:, :2] - now[:, :2]
        body = np.column_stack([
            np.cos(middle) * gone[:, 0] + np.sin(middle) * gone[:, 1], np.cos(middle) * gone[:, 1] - np.sin(middle) * gone[:, 0], turned,
        ])  # fmt: skip
        if terms:
            time = begin + (step + 0.5) * dt
            command, since = situation(track, time)
            ahead = pose + np.column_stack([np.zeros((len(pose), 2)), 0.5 * turned])
            ahead[:, :2] += 0.5 * _turned(body[:, :2], ahead[:, 2])
            at = Circumstances(ahead, body[:, ::2] / dt[:, None], command, since, time, np.full(len(pose), float(robot)))
            body = body + _corrections(terms, at, group) * dt[:, None]
        pose[:, :2] += _turned(body[:, :2], pose[:, 2] + 0.5 * body[:, 2]) + then[:, 3:] - now[:, 3:]
        pose[:, 2] += body[:, 2]
        now = then
    pose[:, 2] += yaw
    return np.asarray(pose)


def _at(times: FloatArray, fine: FloatArray, path: FloatArray, drift: FloatArray) -> FloatArray:
    return np.column_stack([np.interp(times, fine, column) for column in (*path.T, *drift.T)])


def _turned(moved: FloatArray, heading: FloatArray) -> FloatArray:
    c, s = np.cos(heading), np.sin(heading)
    return np.column_stack([c * moved[:, 0] - s * moved[:, 1], s * moved[:, 0] + c * moved[:, 1]])


def _table(term: Term) -> dict[str, Any]:
    """Return a correction on a grid: its value for each unit of what it is proportional to."""
    name, centres = term.basis.depends_on, term.basis.centres
    if name == "heading":
        grid = np.linspace(0, 2 * np.pi, 25)
        coordinates = np.column_stack([np.cos(grid), np.sin(grid)])
        points: list[Any] = grid.tolist()
    elif name == "place":
        coordinates, points = centres, centres.tolist()
    else:
        coordinates = centres if name == "robot" else np.linspace(centres.min(), centres.max(), 25)[:, None]
        points = coordinates[:, 0].tolist()
    channel = list(CHANNELS)[term.channel]
    values = term.basis(coordinates) @ term.weights
    return {
        "channel": channel, "depends_on": name, "proportional_to": term.carrier, "unit": CHANNELS[channel], "at": points,
        "value": values.tolist(),
    }  # fmt: skip

"""Which effects of the sensor explain a log's detections, given where the robots were.

A reading tells whether another robot's disc met the sensor's sector. Measured poses blur the sector's edges; misses and false
detections are chance. The likelihood of all readings then says which parameters of the sensor, and which effects, explain them.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.special import ndtr
from scipy.stats import chi2

from swarm_envs.calibration.arrays import BoolArray, FloatArray
from swarm_envs.calibration.drive.fitting import Model
from swarm_envs.calibration.drive.identification import Identified
from swarm_envs.calibration.drive.lost_commands import delivered
from swarm_envs.calibration.drive.motion import free_run
from swarm_envs.calibration.drive.noise import HEADING, PLACE
from swarm_envs.calibration.logs.log import Log, Track
from swarm_envs.calibration.logs.near_contact import may_touch
from swarm_envs.calibration.selection.causes import CLOSE, SIGNIFICANT, Cause, Estimate
from swarm_envs.calibration.selection.profile import edge
from swarm_envs.worlds import WorldSpec

GRID = 0.01
"""Step in s at which paths are tabulated."""
TURNING_OVER = 0.1
"""Time in s over which a measured turn rate is taken."""
SURPRISE = 2e-3
"""Probability of a reading that nothing in the model allows."""
MOST = 6000
"""Readings that are looked at, about; of more, each second or third and so on: readings that follow each other tell much the same."""
ENOUGH = 100
"""Readings without which nothing is said about the sensor."""


@dataclass(frozen=True)
class SensorEffect:
    """An effect of the sensor that may be named."""

    name: str
    parameter: str
    unit: str
    low: float
    high: float
    minimum_effect: float
    """Departure that is too small to matter, or to be told from the poses' errors."""
    sentence: str


EFFECTS: tuple[SensorEffect, ...] = (
    SensorEffect("detection_range", "range", "m", 0.05, 4.0, 0.005, "It sees robots up to {range:.3g} m away."),
    SensorEffect("field_of_view", "half_angle", "rad", 0.005, 1.5, 0.004, "It sees {half_angle:.3g} rad to each side."),
    SensorEffect("sensor_yaw", "yaw", "rad", -1.5, 1.5, 0.004, "Its sensor is turned by {yaw:.3g} rad."),
    SensorEffect(
        "missed_detections", "probability", "1", 0.0, 0.98, 0.008, "It misses a robot in view with probability {probability:.3g}."
    ),
    SensorEffect("misses_when_turning", "rate", "s/rad", 0.0, 3.0, 0.01, "It misses {rate:.3g} of readings for each rad/s of turning."),
    SensorEffect(
        "false_detections", "probability", "1", 0.0, 0.98, 0.003, "It reports nobody as a robot with probability {probability:.3g}."
    ),
    SensorEffect("sensor_delay", "delay", "s", 0.0, 1.5, 0.02, "A reading is {delay:.3g} s old."),
)
NAMES = tuple(effect.name for effect in EFFECTS)
RANGE, HALF_ANGLE, YAW, MISSED, TURNING, FALSE, DELAY, BLUR = range(8)
"""Order of a sensor's numbers; the last is the logarithm of how much wider its edges are than the tracker's noise makes them."""


@dataclass(frozen=True)
class Views:
    """What each of D readings had around it; O other robots, missing ones infinitely far."""

    distance: FloatArray
    """(D, O) to the other robots' centres in m."""
    bearing: FloatArray
    """(D, O) of their centres from the heading in rad."""
    turning: FloatArray
    """(D,) absolute turn rate in rad/s."""
    detected: BoolArray
    """(D,) what was reported."""
    run: FloatArray
    """(D,) index of the run."""


@dataclass(frozen=True)
class _Path:
    """One robot of a run on a grid of :data:`GRID` s."""

    begin: float
    poses: FloatArray
    """(T, 4) x and y in m, heading in rad as measured, absolute turn rate in rad/s as the drive's model has it."""
    measured: BoolArray


class _Readings:
    """The readings of a log, with views at any delay."""

    def __init__(self, log: Log, model: Model, robots: Sequence[str]) -> None:
        self.runs: list[list[tuple[Track, _Path]]] = []
        for run in log.runs:
            tracks = [track for track in log.tracks if track.run == run and len(track.times) > 1 and track.robot in robots]
            touching = may_touch(log, tracks)
            paths = [_path(track, model, robots.index(track.robot), near) for track, near in zip(tracks, touching, strict=True)]
            self.runs.append(list(zip(tracks, paths, strict=True)))
        self.stride = max(1, round(sum(len(track.detection_times) for tracks in self.runs for track, _ in tracks) / MOST))
        self.most = max([len(tracks) for tracks in self.runs], default=0)
        self.known: dict[int, Views] = {}

    def views(self, delay: float) -> Views:
        """Return what was in view ``delay`` s before each reading, to the grid's step."""
        late = round(delay / GRID)
        if late not in self.known:
            if len(self.known) > 40:
                self.known.clear()
            self.known[late] = self._look(late * GRID)
        return self.known[late]

    def _look(self, delay: float) -> Views:
        parts: list[Views] = []
        for number, tracks in enumerate(self.runs):
            for track, path in tracks:
                # readings whose view the tracker saw with every delay that is tried, so that all delays explain the same readings
                times = track.detection_times[:: self.stride]
                kept = (times >= path.begin + 1.5) | (times - delay >= path.begin)
                kept &= times <= path.begin + GRID * (len(path.poses) - 1)
                looked = np.maximum(times[kept] - delay, path.begin)
                me, seen = _at(path, looked)
                distance = np.full((len(looked), max(1, self.most - 1)), np.inf)
                bearing = np.zeros_like(distance)
                column = 0
                for other, other_path in tracks:
                    if other is track:
                        continue
                    place, there = _at(other_path, looked)
                    gone = place[:, :2] - me[:, :2]
                    distance[:, column] = np.where(there, np.hypot(*gone.T), np.inf)
                    off = np.arctan2(gone[:, 1], gone[:, 0]) - me[:, 2]
                    bearing[:, column] = (off + np.pi) % (2 * np.pi) - np.pi
                    column += 1
                turning = me[:, 3]
                detected = track.detections[:: self.stride][kept]
                parts.append(Views(distance[seen], bearing[seen], turning[seen], detected[seen], np.full(int(seen.sum()), float(number))))
        if not parts:
            return Views(np.empty((0, 1)), np.empty((0, 1)), np.empty(0), np.empty(0, bool), np.empty(0))
        return Views(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in dataclasses.fields(Views)))


def _path(track: Track, model: Model, robot: int, touching: BoolArray) -> _Path:
    """Tabulate a path.

    Poses are not smoothed: a controller turns where a reading changes, and a smoothed corner would feign a late sensor. A corner that
    falls between two poses is where the model has it.

    Args:
        track: The track.
        model: Its drive.
        robot: Index of its robot.
        touching: (T,) whether the robot may be in contact; it then turns as measured, not as the model has it.
    """
    times = track.times
    # readings are taken at whole multiples of a hundredth of a second, if at any
    grid = np.arange(np.ceil(times[0] / GRID - 1e-6) * GRID, times[-1], GRID)
    near = np.searchsorted(times, grid)
    gap = times[np.minimum(near, len(times) - 1)] - times[np.maximum(near - 1, 0)]
    gain, told = model.gains[robot], delivered(track, model, robot)
    turned = free_run(model.parameters, dataclasses.replace(told, times=grid), gain).path[:, 2]
    corners = turned - np.interp(grid, times, free_run(model.parameters, told, gain).path[:, 2])
    poses = np.column_stack([np.interp(grid, times, track.poses[:, k]) for k in range(3)])
    held = np.interp(grid, times, touching.astype(float)) > 0.0
    before = np.interp(grid - TURNING_OVER, times, track.poses[:, 2])
    turning = np.where(held, np.abs(poses[:, 2] - before) / TURNING_OVER, np.abs(np.diff(turned, prepend=turned[0])) / GRID)
    poses[:, 2] += np.where(held | (gap > 2 * TURNING_OVER), 0.0, corners)
    return _Path(float(grid[0]) if len(grid) else float(times[0]), np.column_stack([poses, turning]), gap < 0.3)


def _at(path: _Path, times: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Return the poses and turn rates (D, 4) at some times and whether (D,) they were measured."""
    index = np.round((times - path.begin) / GRID).astype(np.int64)
    inside = (index >= 0) & (index < len(path.poses))
    index = np.clip(index, 0, len(path.poses) - 1)
    return path.poses[index], inside & path.measured[index]


@dataclass(frozen=True)
class SensorFindings:
    """What explains a log's detections."""

    causes: tuple[Cause, ...]
    rejected: tuple[tuple[str, float], ...]
    indistinguishable: tuple[tuple[str, ...], ...]


def identify_sensor(log: Log, world: WorldSpec, drive: Identified, progress: Callable[[str], None] = lambda text: None) -> SensorFindings:
    """Name the effects of the sensor that explain a log's detections.

    Args:
        log: The log.
        world: Its first robot's first sensor is what the log is compared with.
        drive: What explains the log's drives: turn rates and the tracker's noise.
        progress: Called with a line at each step.
    """
    search = _Search(log, world, drive)
    if len(search.readings.views(0.0).detected) < ENOUGH or search.readings.most < 2:
        return SensorFindings((), (), ())
    return search.run(progress)


class _Search:
    def __init__(self, log: Log, world: WorldSpec, drive: Identified) -> None:
        robot = world.robots[0]
        sensor, effects = robot.sensors[0], robot.effects
        self.readings = _Readings(log, drive.model, drive.robots)
        self.radius = robot.body.visible_radius
        self.at_full_range, self.when_driving = effects.misses_at_full_range, effects.misses_when_driving
        noise = drive.model.noise
        self.place, self.heading = max(float(noise[PLACE]), 5e-4), max(float(noise[HEADING]), 1e-3)
        self.numbers = np.array([
            sensor.range, sensor.half_angle, sensor.bearing + effects.sensor_yaw, effects.missed_detections, effects.misses_when_turning,
            effects.false_detections, effects.sensor_delay, 0.0,
        ])  # fmt: skip
        self.bearing = sensor.bearing
        self.base = self.numbers.copy()
        self.named: list[int] = []

    def log_likelihood(self, numbers: FloatArray, runs: Sequence[float] | None = None) -> float:
        """Return the log-likelihood of all readings, or of those of some runs."""
        views = self.readings.views(float(numbers[DELAY]))
        blur = np.exp(numbers[BLUR])
        near = np.maximum(views.distance, 1e-3)
        appears = np.arcsin(np.minimum(1.0, self.radius / near))
        edge_sd = blur * np.sqrt(self.heading**2 + 2.0 * (self.place / near) ** 2)
        off = np.abs((views.bearing - numbers[YAW] + np.pi) % (2 * np.pi) - np.pi)
        inside = ndtr((numbers[RANGE] - near) / (blur * 1.414 * self.place)) * ndtr((numbers[HALF_ANGLE] + appears - off) / edge_sd)
        seen = 1.0 - np.prod(1.0 - inside, axis=1)
        miss = numbers[MISSED] + numbers[TURNING] * views.turning
        if self.at_full_range > 0.0:
            nearest = np.where(inside > 0.5, near, np.inf).min(axis=1)
            miss = miss + self.at_full_range * np.minimum(1.0, np.where(np.isfinite(nearest), nearest, 0.0) / numbers[RANGE]) ** 2
        report = seen * (1.0 - np.clip(miss, 0.0, 1.0)) + (1.0 - seen) * numbers[FALSE]
        report = np.clip(report, SURPRISE, 1.0 - SURPRISE)
        each = np.log(np.where(views.detected, report, 1.0 - report))
        return float(each.sum() if runs is None else each[np.isin(views.run, runs)].sum())

    def run(self, progress: Callable[[str], None]) -> SensorFindings:
        self.numbers, here = self.climb(self.numbers, [BLUR])
        records: dict[int, tuple[float, float]] = {}
        groups: list[tuple[str, ...]] = []
        rejected: tuple[tuple[str, float], ...] = ()
        while len(self.named) < 4:
            trials: list[tuple[float, int, FloatArray]] = []
            for index in range(len(EFFECTS)):
                if index not in self.named:
                    numbers = self.far(self.numbers, index)
                    numbers, value = self.climb(numbers, [*self.named, index, BLUR], 2)
                    trials.append((value - here, index, numbers))
            trials.sort(key=lambda trial: -trial[0])
            progress("sensor: " + ", ".join(f"{NAMES[i]} {gain:.1f}" for gain, i, _ in trials[:4]))
            rejected = tuple((NAMES[i], self.p_value(gain, len(trials))) for gain, i, _ in trials)
            real = [trial for trial in trials[:2] if self.p_value(trial[0], len(trials)) < SIGNIFICANT and self.matters(trial[1], trial[2])]
            better = next(((trial, gained) for trial in real if (gained := self.heldout(trial[1])) > 0.0), None)
            if better is None:
                break
            (gain, index, numbers), gained = better
            close = [NAMES[i] for other, i, _ in trials if i != index and gain - other < CLOSE]
            if close:
                groups.append((NAMES[index], *close))
            records[index] = (gained, self.p_value(gain, len(trials)))
            self.named.append(index)
            self.numbers, here = self.climb(numbers, [*self.named, BLUR], 4)
            here = self.drop_idle(here)
        causes = tuple(self.cause(index, *records[index]) for index in self.named)
        return SensorFindings(causes, rejected, tuple(groups))

    @staticmethod
    def p_value(gain: float, tried: int) -> float:
        return float(min(1.0, tried * chi2.sf(2.0 * max(0.0, gain), 1)))

    def matters(self, index: int, numbers: FloatArray) -> bool:
        """Whether an effect departs from the world by more than what poses and readings could feign."""
        return bool(abs(numbers[index] - self.base[index]) > EFFECTS[index].minimum_effect)

    def drop_idle(self, here: float) -> float:
        """Take out effects that a later one has made unnecessary; returns the log-likelihood."""
        for index in list(self.named[:-1]):
            others = [i for i in self.named if i != index]
            numbers = self.numbers.copy()
            numbers[index] = self.base[index]
            numbers, value = self.climb(numbers, [*others, BLUR], 3)
            if self.p_value(here - value, len(EFFECTS)) > SIGNIFICANT or not self.matters(index, self.numbers):
                self.named, self.numbers, here = others, numbers, value
        return here

    def heldout(self, index: int) -> float:
        """Return what an effect gains on the runs that it was not fitted to, in nats."""
        runs = np.unique(self.readings.views(0.0).run)
        if len(runs) < 2:
            return 1.0
        total = 0.0
        for fold in range(2):
            train, test = runs[fold::2].tolist(), runs[1 - fold :: 2].tolist()
            before, _ = self.climb(self.numbers, [*self.named, BLUR], 1, train)
            after, _ = self.climb(self.far(self.numbers, index, train), [*self.named, index, BLUR], 2, train)
            total += self.log_likelihood(after, test) - self.log_likelihood(before, test)
        return total

    def far(self, numbers: FloatArray, index: int, runs: Sequence[float] | None = None) -> FloatArray:
        """Return the numbers with one at the best of a coarse grid over all that it may be."""
        effect = EFFECTS[index]
        if index in (MISSED, FALSE, TURNING):
            grid = np.array([0.01, 0.05, 0.15, 0.3, 0.6])
        elif index == YAW:
            grid = self.base[YAW] + np.linspace(-0.5, 0.5, 41)
        elif index == DELAY:
            grid = np.arange(0.0, 0.9, 0.04)
        else:
            grid = self.base[index] * np.geomspace(0.2, 4.0, 40)
        trials = [numbers]
        for value in grid[(grid >= effect.low) & (grid <= effect.high)]:
            trial = numbers.copy()
            trial[index] = value
            trials.append(trial)
        return trials[int(np.argmax([self.log_likelihood(trial, runs) for trial in trials]))]

    def climb(
        self, numbers: FloatArray, what: Sequence[int], rounds: int = 1, runs: Sequence[float] | None = None
    ) -> tuple[FloatArray, float]:
        """Improve some numbers one after the other; returns them and the log-likelihood."""
        numbers = numbers.copy()
        best = self.log_likelihood(numbers, runs)
        for _ in range(rounds):
            begun = best
            for index in what:
                value, best = self.along(numbers, index, best, runs)
                numbers[index] = value
            if best - begun < 0.05:
                break
        return numbers, best

    def along(self, numbers: FloatArray, index: int, best: float, runs: Sequence[float] | None) -> tuple[float, float]:
        """Return the best value of one number near its present one, and the log-likelihood there."""
        now = float(numbers[index])
        if index == BLUR:
            low, high = -1.0, 4.0
        else:
            effect = EFFECTS[index]
            reach = {RANGE: 0.15 * now, HALF_ANGLE: 0.15 * now, YAW: 0.04, DELAY: 0.06}.get(index, max(0.03, 0.7 * now))
            low, high = max(effect.low, now - reach), min(effect.high, now + reach)

        def loss(value: float) -> float:
            trial = numbers.copy()
            trial[index] = value
            return -self.log_likelihood(trial, runs)

        if index == DELAY:
            places = np.arange(np.ceil(low / GRID), np.floor(high / GRID) + 1) * GRID
            losses = [loss(float(place)) for place in places]
            found, value = float(places[int(np.argmin(losses))]), -min(losses)
        else:
            result = minimize_scalar(loss, bounds=(low, high), method="bounded", options={"xatol": 1e-4 if index != BLUR else 0.05})
            found, value = float(result.x), -float(result.fun)
        return (found, value) if value > best else (now, best)

    def cause(self, index: int, gain: float, p: float) -> Cause:
        effect = EFFECTS[index]
        value = float(self.numbers[index])
        best = self.log_likelihood(self.numbers)

        def drop(trial: float) -> float:
            numbers = self.numbers.copy()
            numbers[index] = trial
            if index != DELAY and len(self.named) > 1:
                # the others follow, so that the interval holds what they leave open
                return best - self.climb(numbers, [i for i in self.named if i != index], 1)[1]
            return best - self.log_likelihood(numbers)

        reach = max(0.5 * abs(value), 0.2)
        low = edge(drop, value, max(effect.low, value - reach)) - 0.1 * effect.minimum_effect
        high = edge(drop, value, min(effect.high, value + reach)) + 0.1 * effect.minimum_effect
        if index == DELAY:
            low, high = low - 0.5 * GRID, high + 0.5 * GRID
        shift = self.bearing if index == YAW else 0.0
        number = Estimate(value - shift, (max(effect.low, low - shift), min(effect.high, high - shift)), effect.unit)
        return Cause(effect.name, {effect.parameter: number}, gain, p, effect.sentence.format(**{effect.parameter: number.estimate}))

"""Which numbers of contact explain how robots push each other and scrape along walls, by the Simulation itself."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.stats import chi2

from swarm_envs.calibration.apply_effects import extend
from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.logs.log import Log, Track
from swarm_envs.calibration.logs.near_contact import may_touch
from swarm_envs.calibration.selection.causes import CLOSE, SIGNIFICANT, Cause, Estimate
from swarm_envs.calibration.selection.profile import edge
from swarm_envs.simulation import Simulation
from swarm_envs.worlds import WorldSpec
from swarm_envs.worlds.errors import WorldError

SPAN = 1.0
"""Length in s of the windows that are simulated."""
TICK = 0.02
"""Tick in s with which they are."""
MOST = 400
"""Windows at most."""
ENOUGH = 20
"""Windows with robots near each other or a wall, without which nothing is said about contact."""
TAIL = 3.0
"""Degrees of freedom of the errors' t distribution: after a contact a small error of a start grows large at times."""
OPEN = 1000.0
"""Half the side in m of the hall that stands for an arena without known walls."""


@dataclass(frozen=True)
class ContactEffect:
    """A number of contact that may be named."""

    name: str
    parameter: str
    unit: str
    grid: tuple[float, ...]
    """Where to search first; for the radius as shares of the world's."""
    minimum_effect: float
    """Departure that is too small to matter."""
    sentence: str


FRICTIONS = (0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.65, 0.8, 1.0, 1.3)
EFFECTS: tuple[ContactEffect, ...] = (
    ContactEffect(
        "robot_friction", "coefficient", "1", FRICTIONS, 0.04, "Robots rub on each other with a coefficient of {coefficient:.3g}."
    ),
    ContactEffect("wall_friction", "coefficient", "1", FRICTIONS, 0.04, "Walls rub on robots with a coefficient of {coefficient:.3g}."),
    ContactEffect(
        "collision_radius",
        "radius",
        "m",
        tuple(np.linspace(0.65, 1.45, 33).tolist()),
        1e-3,
        "Robots touch at {radius:.3g} m from the centre.",
    ),
)
ROBOTS, WALLS, RADIUS = range(3)


@dataclass(frozen=True)
class Windows:
    """W windows of R robots."""

    start: FloatArray
    """(W, R, 3) measured poses."""
    end: FloatArray
    """(W, R, 3) measured poses, SPAN s later."""
    near: FloatArray
    """(W, R) whether the robot may touch something in the window."""
    commands: FloatArray
    """(T, W, R, 2) mean commands of each tick."""
    run: FloatArray
    """(W,) index of the run."""


def contact_windows(log: Log) -> Windows | None:
    """Return the windows in which something may touch, or None where there are too few."""
    known = {(track.run, track.robot): flags for track, flags in zip(log.tracked, may_touch(log, log.tracked), strict=True)}
    runs = [[track for track in log.tracked if track.run == run] for run in log.runs]
    robots = max((len(tracks) for tracks in runs), default=0)
    starts, ends, near, commands, numbers = [], [], [], [], []
    for number, tracks in enumerate(runs):
        if len(tracks) != robots or not tracks:
            continue
        begin, end = max(track.times[0] for track in tracks), min(track.times[-1] for track in tracks)
        for at in np.arange(begin, end - SPAN, SPAN):
            touches = [bool(known[t.run, t.robot][(t.times >= at) & (t.times <= at + SPAN)].any()) for t in tracks]
            if any(touches):
                starts.append([_pose(track, at) for track in tracks])
                ends.append([_pose(track, at + SPAN) for track in tracks])
                near.append(touches)
                commands.append([_mean_commands(track, at) for track in tracks])
                numbers.append(number)
    if len(starts) < ENOUGH:
        return None
    kept = np.unique(np.linspace(0, len(starts) - 1, min(MOST, len(starts))).astype(int))
    return Windows(
        np.array(starts)[kept], np.array(ends)[kept], np.array(near, float)[kept],
        np.ascontiguousarray(np.array(commands)[kept].transpose(2, 0, 1, 3)), np.array(numbers, float)[kept],
    )  # fmt: skip


def _pose(track: Track, at: float) -> list[float]:
    return [float(np.interp(at, track.times, track.poses[:, k])) for k in range(3)]


def _mean_commands(track: Track, at: float) -> FloatArray:
    """Return the mean command (T, 2) of each tick."""
    edges = at + TICK * np.arange(round(SPAN / TICK) + 1)
    times, commands = np.append(track.command_times, edges[-1] + 1e3), np.vstack([track.commands, track.commands[-1:]])
    # commands are steps, their integral is a polygon; before the first a robot stands
    gone = np.vstack([np.zeros((1, 2)), np.cumsum(np.diff(times)[:, None] * commands[:-1], axis=0)])
    integral = np.column_stack([np.interp(edges, times, gone[:, k], left=0.0) for k in range(2)])
    return np.asarray(np.diff(integral, axis=0) / TICK)


@dataclass(frozen=True)
class ContactFindings:
    """What explains a log's contacts."""

    causes: tuple[Cause, ...]
    rejected: tuple[tuple[str, float], ...]
    indistinguishable: tuple[tuple[str, ...], ...]


def identify_contact(
    log: Log, world: WorldSpec, drive: Sequence[Cause], progress: Callable[[str], None] = lambda text: None
) -> ContactFindings:
    """Name the numbers of contact that differ from a world's.

    Args:
        log: The log.
        world: What it is compared with.
        drive: Effects of the drive that were named before; they act in the simulation too.
        progress: Called with a line at each step.
    """
    windows = contact_windows(log)
    nothing = ContactFindings((), (), ())
    if windows is None or (log.outline is None and windows.start.shape[1] < 2):
        return nothing
    try:
        return _Search(log, extend(world, drive, log.name), windows).run(progress)
    except WorldError:
        # an arena of the log that no world can have; its drives and detections stand without it
        return nothing


class _Search:
    def __init__(self, log: Log, world: WorldSpec, windows: Windows) -> None:
        outline = log.outline or ((-OPEN, -OPEN), (OPEN, -OPEN), (OPEN, OPEN), (-OPEN, OPEN))
        arena = dataclasses.replace(world.arena, outline=outline, obstacles=())
        certain = world.with_effects(
            command_loss=0.0, start_kick_mean=0.0, start_kick_sd=0.0, linear_gain_spread=0.0, angular_gain_spread=0.0
        )
        self.world = certain.replace(arena=arena, objects=(), tick=TICK).with_robots(windows.start.shape[1])
        self.windows = windows
        self.numbers = np.array([world.contact.robot_friction, world.contact.wall_friction, world.robots[0].body.contact_radius])
        self.base = self.numbers.copy()
        self.named: list[int] = []
        self.known: dict[tuple[float, ...], FloatArray] = {}

    def errors(self, numbers: FloatArray) -> FloatArray:
        """Return the errors (W, R, 3) of the simulation's end poses."""
        key = tuple(np.round(numbers, 7).tolist())
        if key not in self.known:
            contact = dataclasses.replace(self.world.contact, robot_friction=key[ROBOTS], wall_friction=key[WALLS])
            robots = tuple(
                dataclasses.replace(
                    robot,
                    body=dataclasses.replace(
                        robot.body, contact_radius=key[RADIUS], visible_radius=min(robot.body.visible_radius, key[RADIUS])
                    ),
                )
                for robot in self.world.robots
            )
            simulation = Simulation(self.world.replace(contact=contact, robots=robots), len(self.windows.start), engine="disc")
            simulation.poses[:] = self.windows.start
            for commands in self.windows.commands:
                simulation.step(commands)
            errors = simulation.poses - self.windows.end
            errors[..., 2] = (errors[..., 2] + np.pi) % (2 * np.pi) - np.pi
            self.known[key] = errors
        return self.known[key]

    def log_likelihood(self, numbers: FloatArray, runs: Sequence[float] | None = None, scale: FloatArray | None = None) -> float:
        """Return the log-likelihood of the end poses of robots near something, the errors' scale being the likeliest unless given."""
        errors = self.kept(numbers, runs)
        scale = self.scale(errors) if scale is None else scale
        shape = np.log1p((errors / scale) ** 2 / TAIL)
        return float(-np.sum(0.5 * (TAIL + 1) * shape) - len(errors) * np.sum(np.log(scale)))

    def kept(self, numbers: FloatArray, runs: Sequence[float] | None) -> FloatArray:
        """Return the errors (N, 3) of robots near something."""
        chosen = self.windows.near > 0.5
        if runs is not None:
            chosen = chosen & np.isin(self.windows.run, runs)[:, None]
        return self.errors(numbers)[chosen]

    @staticmethod
    def scale(errors: FloatArray) -> FloatArray:
        """Return the likeliest scale (3,) of errors (N, 3), one for both coordinates."""
        scale = np.maximum(np.median(np.abs(errors), axis=0), 1e-6)
        for _ in range(20):
            squares = np.mean((TAIL + 1) * errors**2 / (TAIL + (errors / scale) ** 2), axis=0)
            squares[:2] = squares[:2].mean()
            scale = np.sqrt(np.maximum(squares, 1e-12))
        return np.asarray(scale)

    def run(self, progress: Callable[[str], None]) -> ContactFindings:
        here = self.log_likelihood(self.numbers)
        records: dict[int, tuple[float, float]] = {}
        groups: list[tuple[str, ...]] = []
        rejected: tuple[tuple[str, float], ...] = ()
        while len(self.named) < len(EFFECTS):
            trials: list[tuple[float, int, FloatArray]] = []
            for index in range(len(EFFECTS)):
                if index not in self.named:
                    numbers = self.refine(self.far(self.numbers, index), [index])
                    trials.append((self.log_likelihood(numbers) - here, index, numbers))
            trials.sort(key=lambda trial: -trial[0])
            progress("contact: " + ", ".join(f"{EFFECTS[i].name} {gain:.1f}" for gain, i, _ in trials))
            rejected = tuple((EFFECTS[i].name, self.p_value(gain)) for gain, i, _ in trials)
            gain, index, numbers = trials[0]
            large = abs(numbers[index] - self.base[index]) > EFFECTS[index].minimum_effect
            if self.p_value(gain) > SIGNIFICANT or not large:
                break
            held_out = self.heldout(index, numbers)
            if held_out <= 0.0:
                break
            close = [EFFECTS[i].name for other, i, _ in trials[1:] if gain - other < CLOSE]
            if close:
                groups.append((EFFECTS[index].name, *close))
            records[index] = (held_out, self.p_value(gain))
            self.named.append(index)
            self.numbers = self.refine(numbers, self.named)
            here = self.log_likelihood(self.numbers)
        return ContactFindings(tuple(self.cause(index, *records[index]) for index in self.named), rejected, tuple(groups))

    @staticmethod
    def p_value(gain: float) -> float:
        return float(min(1.0, len(EFFECTS) * chi2.sf(2.0 * max(0.0, gain), 1)))

    def heldout(self, index: int, fitted: FloatArray) -> float:
        """Return what a number gains on runs that it was not fitted to, in nats."""
        runs = np.unique(self.windows.run)
        if len(runs) < 2:
            return 1.0
        total = 0.0
        for fold in range(2):
            train, test = runs[fold::2].tolist(), runs[1 - fold :: 2].tolist()
            after = self.refine(fitted, [index], train)
            scales = [self.scale(self.kept(numbers, train)) for numbers in (self.numbers, after)]
            total += self.log_likelihood(after, test, scales[1]) - self.log_likelihood(self.numbers, test, scales[0])
        return total

    def far(self, numbers: FloatArray, index: int) -> FloatArray:
        """Return the numbers with one at the best of its grid."""
        trials = [numbers]
        for value in EFFECTS[index].grid:
            trial = numbers.copy()
            trial[index] = value * self.base[RADIUS] if index == RADIUS else value
            trials.append(trial)
        return trials[int(np.argmax([self.log_likelihood(trial) for trial in trials]))]

    def refine(self, numbers: FloatArray, what: Sequence[int], runs: Sequence[float] | None = None) -> FloatArray:
        """Improve some numbers one after the other."""
        numbers = numbers.copy()
        for index in what:
            reach = 0.04 * numbers[index] if index == RADIUS else max(0.06, 0.3 * numbers[index])

            def loss(value: float, index: int = index) -> float:
                trial = numbers.copy()
                trial[index] = value
                return -self.log_likelihood(trial, runs)

            bounds = (max(0.0, numbers[index] - reach), numbers[index] + reach)
            found = minimize_scalar(
                loss, bounds=bounds, method="bounded", options={"xatol": 0.002 * reach if index == RADIUS else 0.02 * reach, "maxiter": 14}
            )
            if found.fun < loss(float(numbers[index])):
                numbers[index] = float(found.x)
        return numbers

    def cause(self, index: int, gain: float, p: float) -> Cause:
        effect = EFFECTS[index]
        value, best = float(self.numbers[index]), self.log_likelihood(self.numbers)

        def drop(trial: float) -> float:
            numbers = self.numbers.copy()
            numbers[index] = trial
            return best - self.log_likelihood(numbers)

        reach = 0.1 * value if index == RADIUS else max(0.2, 0.7 * value)
        blur = 0.2 * effect.minimum_effect
        interval = (max(0.0, edge(drop, value, max(0.0, value - reach)) - blur), edge(drop, value, value + reach) + blur)
        number = Estimate(value, interval, effect.unit)
        return Cause(effect.name, {effect.parameter: number}, gain, p, effect.sentence.format(**{effect.parameter: value}))

"""The effects that may explain what a world's drive gets wrong, each with its parameters, bounds and a sentence."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.drive.measured import Measured
from swarm_envs.calibration.drive.parameters import DECLARED, INDEX

Grid = Callable[[FloatArray, Measured], list[tuple[float, ...]]]
"""From the present parameters and the data to places from which to search."""


@dataclass(frozen=True)
class Parameter:
    """One number of an effect; unit and bounds are those of its declaration."""

    name: str
    """As the findings call it."""
    field: str
    """Name in :data:`swarm_envs.calibration.drive.parameters.PARAMETERS`."""
    minimum_effect: float
    """Departure from the present value that is too small to matter for what a robot does, and that simulations of different time
    steps already differ by: an effect of less is not named, and no interval is narrower than a tenth of it."""
    slope_over: float | None = None
    """Difference over which slopes are taken; by default a tenth of the minimum effect."""
    search: tuple[float, float] | None = None
    """Smallest and largest value searched where they are not those of the declaration."""
    also: tuple[str, ...] = ()
    """Other effects of a world that are the same number."""

    @property
    def index(self) -> int:
        """Index in the drive's parameters."""
        return INDEX[self.field]

    @property
    def unit(self) -> str:
        """SI unit."""
        return str(DECLARED[self.field].metadata["unit"])

    @property
    def low(self) -> float:
        """Smallest value searched."""
        return self._searched[0]

    @property
    def high(self) -> float:
        """Largest value searched."""
        return self._searched[1]

    @property
    def _searched(self) -> tuple[float, float]:
        declared = DECLARED[self.field].metadata
        return self.search or declared.get("search", (declared["low"], declared["high"]))

    @property
    def step(self) -> float:
        """Difference over which slopes are taken."""
        return 0.1 * self.minimum_effect if self.slope_over is None else self.slope_over


@dataclass(frozen=True)
class Candidate:
    """An effect that may be named."""

    name: str
    parameters: tuple[Parameter, ...]
    sentence: str
    """What it means, for a person; parameters in braces."""
    starts: Grid
    """Where to search from."""
    smooth: bool = True
    """Whether the likelihood has slopes; else ``starts`` is the whole search."""
    world: bool = True
    """Whether it belongs into the world, and not to the measurement."""
    confounded_with: tuple[str, ...] = field(default=())
    """Effects that no such log can tell from this one."""


def _fixed(*places: tuple[float, ...]) -> Grid:
    return lambda parameters, data: list(places)


def _here(*fields: str) -> Grid:
    return lambda parameters, data: [tuple(float(parameters[INDEX[name]]) for name in fields)]


def rim_speeds(parameters: FloatArray, data: Measured) -> FloatArray:
    """Return the distinct rim speeds that were commanded, in m/s, rising, zero left out."""
    half = 0.5 * parameters[INDEX["wheel_base"]] * data.commands[:, 1]
    speeds = np.abs(np.concatenate([data.commands[:, 0] - half, data.commands[:, 0] + half]))
    return np.unique(np.round(speeds[speeds > 1e-4], 5))


def thresholds(parameters: FloatArray, data: Measured) -> FloatArray:
    """Return a threshold between each commanded rim speed and the next, in m/s: any other acts like one of these."""
    speeds = rim_speeds(parameters, data)
    speeds = speeds[speeds < 0.6 * speeds.max()] if len(speeds) > 3 else speeds[:1]
    return np.asarray(0.5 * (speeds[1:] + speeds[:-1]))


def _some_thresholds(parameters: FloatArray, data: Measured) -> list[tuple[float, ...]]:
    between = thresholds(parameters, data)
    return [(float(value),) for value in between[:: max(1, len(between) // 40)]]


def _below_fastest(parameters: FloatArray, data: Measured) -> list[tuple[float, ...]]:
    speeds = rim_speeds(parameters, data)
    top = speeds.max() * parameters[INDEX["linear_gain"]] if len(speeds) else 1.0
    return [(float(share * top),) for share in (0.9, 0.75, 0.6, 0.45, 0.3)]


DRIVE_CANDIDATES: tuple[Candidate, ...] = (
    Candidate(
        "linear_gain", (Parameter("gain", "linear_gain", 0.003, 1e-4),),
        "It drives {gain:.3g} times as fast as commanded.", _here("linear_gain"),
    ),
    Candidate(
        "angular_gain", (Parameter("gain", "angular_gain", 0.003, 1e-4),),
        "It turns {gain:.3g} times as fast as commanded.", _here("angular_gain"),
    ),
    Candidate(
        "turn_bias", (Parameter("bias", "turn_bias", 0.01),),
        "It turns {bias:.3g} rad on each metre that it drives.", _here("turn_bias"),
    ),
    Candidate(
        "dead_time", (Parameter("delay", "dead_time", 0.005, 1e-3),),
        "Commands act {delay:.3g} s late.", _fixed((0.03,), (0.1,), (0.2,), (0.35,), (0.6,)), confounded_with=("clock_offset",),
    ),
    Candidate(
        "motor_lag", (Parameter("time_constant", "motor_lag", 0.01),),
        "Its motors take {time_constant:.3g} s to reach 63 % of a new speed.", _fixed((0.03,), (0.1,), (0.25,), (0.6,)),
    ),
    Candidate(
        "deadband", (Parameter("threshold", "deadband", 1e-3),),
        "A wheel asked for less than {threshold:.3g} m/s stands still.", _some_thresholds, smooth=False,
    ),
    Candidate(
        "saturation", (Parameter("limit", "saturation", 1e-3),),
        "No wheel turns faster than {limit:.3g} m/s.", _below_fastest,
    ),
    Candidate(
        "command_loss", (Parameter("probability", "command_loss", 0.005, 1e-3),),
        "A command is lost with probability {probability:.3g}.", _fixed((0.05,), (0.2,), (0.4,)),
    ),
    Candidate(
        "gain_drift", (Parameter("rate", "gain_drift", 2e-4, 1e-5),),
        "Both gains fall by {rate:.3g} of their value per second.", _here("gain_drift"),
    ),
    Candidate(
        "floor_drift",
        (Parameter("vx", "floor_drift_x", 3e-4, 1e-5), Parameter("vy", "floor_drift_y", 3e-4, 1e-5)),
        "While it moves it is carried along at ({vx:.3g}, {vy:.3g}) m/s.", _here("floor_drift_x", "floor_drift_y"),
    ),
    Candidate(
        "start_kick",
        (Parameter("mean", "start_kick_mean", 5e-3, 1e-4),
         Parameter("sd", "start_kick_sd", 5e-3, 1e-3)),
        "Each start from rest turns it by {mean:.3g} rad on average, {sd:.3g} rad at random.", _fixed((0.0, 0.03), (0.0, 0.1)),
    ),
    Candidate(
        "turning_slows", (Parameter("slip", "turning_slows", 3e-3, 1e-4),),
        "It drives slower by {slip:.3g} of its speed for each rad/s of turning.", _fixed((0.03,), (0.15,)),
    ),
    Candidate(
        "marker_yaw", (Parameter("yaw", "marker_yaw", 3e-3, 1e-4),),
        "The tracker's marker is turned on the robot by {yaw:.3g} rad.", _here("marker_yaw"), world=False,
    ),
    Candidate(
        "clock_offset", (Parameter("offset", "dead_time", 0.005, 1e-3, search=(-2.0, 0.0)),),
        "Poses carry times that are {offset:.3g} s off the commands'.", _fixed((-0.03,), (-0.1,), (-0.2,), (-0.35,)), world=False,
        confounded_with=("dead_time",),
    ),
)  # fmt: skip
"""Effects of the drive, simplest first."""
SPREAD = Candidate(
    "robot_spread", (Parameter("sd", "linear_gain_spread", 0.0, also=("angular_gain_spread",)),),
    "Robots differ: their gains vary by {sd:.3g} of their value.", _here("linear_gain_spread"),
)  # fmt: skip
"""Has a likelihood of its own, in which each robot has its own gains."""
BY_NAME = {candidate.name: candidate for candidate in DRIVE_CANDIDATES}

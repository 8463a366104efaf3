"""Whether findings hold when runs are left out one at a time."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass

from swarm_envs.calibration.apply_effects import apply_effects
from swarm_envs.calibration.contact.identification import identify_contact
from swarm_envs.calibration.drive.identification import identify
from swarm_envs.calibration.errors import LogError
from swarm_envs.calibration.logs.log import Log
from swarm_envs.calibration.selection.causes import Cause
from swarm_envs.calibration.sensor.identification import identify_sensor
from swarm_envs.worlds import WorldSpec


@dataclass(frozen=True)
class Moved:
    """A parameter over the calibrations without one of the runs."""

    effect: str
    parameter: str
    unit: str
    estimate: float
    """From all runs."""
    ci95: tuple[float, float]
    """From all runs."""
    least: float
    """Smallest estimate with a run left out, among the calibrations that named the effect."""
    most: float
    """Largest."""


@dataclass(frozen=True)
class Stability:
    """What was named with each run left out."""

    runs: int
    """Calibrations, one for each run left out."""
    named: dict[str, int]
    """In how many of them each effect was named; those named from all runs first."""
    from_all: tuple[str, ...]
    """Effects named from all runs."""
    moved: tuple[Moved, ...]
    """How the parameters of effects named from all runs move."""
    without: dict[str, tuple[str, ...]]
    """By run: what was named without it."""

    @property
    def stable(self) -> bool:
        """Whether every calibration names what is named from all runs, and nothing else."""
        return all(set(names) == set(self.from_all) for names in self.without.values())

    def to_document(self) -> dict[str, object]:
        """Return what ``stability.json`` holds."""
        return {**asdict(self), "stable": self.stable}


def leave_one_out(log: Log, world: WorldSpec, causes: Sequence[Cause], progress: Callable[[str], None] = lambda text: None) -> Stability:
    """Repeat a calibration without each of the runs.

    Args:
        log: The log, of at least two runs.
        world: The world that is calibrated.
        causes: What was named from all runs.
        progress: Called with a line for each run.

    Raises:
        LogError: When the log has a single run.
    """
    if len(log.runs) < 2:
        raise LogError(f"{log.name}: one run only; leaving runs out one at a time needs two at least")
    found: dict[str, tuple[Cause, ...]] = {}
    for run in log.runs:
        rest = dataclasses.replace(log, tracks=tuple(track for track in log.tracks if track.run != run))
        if rest.tracked:
            found[run] = _causes(rest, world)
            progress(f"without {run}: {', '.join(cause.effect for cause in found[run]) or 'nothing'}")
    every = [cause.effect for cause in causes]
    others = [cause.effect for named in found.values() for cause in named]
    counts = {name: others.count(name) for name in dict.fromkeys([*every, *others])}
    moved = []
    for cause in causes:
        for name, number in cause.parameters.items():
            values = [
                other.parameters[name].estimate
                for named in found.values()
                for other in named
                if other.effect == cause.effect and name in other.parameters
            ]
            if values:
                moved.append(Moved(cause.effect, name, number.unit, number.estimate, number.ci95, min(values), max(values)))
    without = {run: tuple(cause.effect for cause in named) for run, named in found.items()}
    return Stability(len(found), counts, tuple(every), tuple(moved), without)


def _causes(log: Log, world: WorldSpec) -> tuple[Cause, ...]:
    drive = identify(log, world)
    sensor = identify_sensor(log, world, drive)
    contact = identify_contact(log, apply_effects(world, drive.causes, log.name))
    return (*drive.causes, *sensor.causes, *contact.causes)

"""One draw of the study: effects hidden in a log, and what the calibration names."""

from __future__ import annotations

import tempfile
import time
import traceback
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from docs.studies.calibration.generator import EFFECTS, UNLISTED, draw, drawn_extra, generate_log

KINDS = ("singles", "pairs", "nulls", "unlisted")
"""Draws with one hidden effect, two, none, and one that is on no list."""
INSEPARABLE = [{"dead_time", "clock_offset"}]
"""Pairs that are never hidden together: no drive could tell their sizes apart."""
DEPENDS_ON = {"slippery_patch": "place", "magnetic_stripe": "place", "heading_speed": "heading"}
"""What each unlisted effect depends on."""


@dataclass(frozen=True)
class Task:
    """One draw.

    Attributes:
        kind: One of KINDS.
        index: Its number among the draws of its kind.
        seed: Seed of its effects, sizes and log.
        procedures: What the lab may do; effects that only other runs show are not hidden.
    """

    kind: str
    index: int
    seed: int
    procedures: tuple[str, ...]

    @property
    def key(self) -> str:
        """Tells the draw from all others."""
        return f"{self.kind} {self.index} {self.seed} {'+'.join(self.procedures)}"


@dataclass
class Outcome:
    """What came of one draw.

    Attributes:
        key: The task's.
        kind: The task's.
        hidden: Parameters of each hidden effect.
        extra: Name of the unlisted effect, if one was hidden.
        named: For each effect named, each parameter's (estimate, low, high).
        groups: Effects that the calibration calls indistinguishable.
        unexplained: What a remainder depends on, if there is one.
        channel: Which channel it is in.
        cut: Share of the held-out error of the listed effects that the correction removes at each horizon, of the heading where
            the turn rate is wrong, else of the place.
        cut_world: The same of the world's error, which has no effects.
        sides: Numbers of runs that drive where an effect of place does not act, and where it does.
        seconds: Time that the calibration took, s.
        error: Its traceback, if it failed.
    """

    key: str
    kind: str
    hidden: dict[str, dict[str, float]]
    extra: str | None = None
    named: dict[str, dict[str, tuple[float, float, float]]] = field(default_factory=dict)
    groups: list[list[str]] = field(default_factory=list)
    unexplained: str | None = None
    channel: str | None = None
    cut: list[float] = field(default_factory=list)
    cut_world: list[float] = field(default_factory=list)
    sides: list[int] = field(default_factory=list)
    seconds: float = 0.0
    error: str | None = None


def names_of(task: Task) -> list[str]:
    """The effects that a task hides."""
    number = {"singles": 1, "pairs": 2}.get(task.kind, 0)
    random = np.random.default_rng([task.seed, 4])
    candidates = [name for name, effect in EFFECTS.items() if effect.procedure in task.procedures]
    while True:
        names = [candidates[k] for k in random.choice(len(candidates), number, replace=False)]
        if set(names) not in INSEPARABLE:
            return names


def perform(task: Task) -> Outcome:
    """Write a log, have it identified, and note what was named."""
    # imported here: the study's counting and its tests need no calibration
    from docs.studies.calibration.sides import runs_on_either_side
    from swarm_envs.calibration import read_log
    from swarm_envs.calibration.apply_effects import apply_effects
    from swarm_envs.calibration.contact.identification import identify_contact
    from swarm_envs.calibration.drive.identification import identify
    from swarm_envs.calibration.residual.residual_dynamics import find_residual_dynamics
    from swarm_envs.calibration.sensor.identification import identify_sensor
    from swarm_envs.worlds import load_world

    outcome = Outcome(task.key, task.kind, draw(names_of(task), task.seed))
    random = np.random.default_rng([task.seed, 5])
    procedures = None
    if task.kind == "nulls":
        procedures = [task.procedures[random.integers(len(task.procedures))]]
    if task.kind == "unlisted":
        outcome.extra = sorted(UNLISTED)[task.index % len(UNLISTED)]
    with tempfile.TemporaryDirectory() as folder:
        log = generate_log(outcome.hidden, Path(folder) / "log", seed=task.seed, extra=outcome.extra, procedures=procedures)
        began = time.perf_counter()
        try:
            measured, world = read_log(log), load_world("hero_plus")
            if outcome.extra is not None and DEPENDS_ON[outcome.extra] == "place":
                outcome.sides = list(runs_on_either_side(measured, drawn_extra(outcome.extra, task.seed)))
            found = identify(measured, world)
            rest = find_residual_dynamics(measured, found)
            seen = identify_sensor(measured, world, found)
            causes = [cause for cause in found.causes if rest is None or cause.effect not in rest.instead_of]
            touched = identify_contact(measured, apply_effects(world, causes, measured.name))
        except Exception:
            outcome.error = traceback.format_exc()
        else:
            for cause in (*causes, *seen.causes, *touched.causes):
                outcome.named[cause.effect] = {
                    name: (float(given.estimate), float(given.ci95[0]), float(given.ci95[1])) for name, given in cause.parameters.items()
                }
            outcome.groups = [list(group) for group in (*found.indistinguishable, *seen.indistinguishable, *touched.indistinguishable)]
            if rest is not None:
                outcome.unexplained = rest.discrepancy.depends_on
                outcome.channel = rest.discrepancy.channel
                metric = "heading" if rest.discrepancy.channel == "turn rate" else "position"
                rows = [asdict(row) for row in rest.heldout]
                outcome.cut = [1.0 - row[f"{metric}_after"] / row[f"{metric}_before"] for row in rows]
                outcome.cut_world = [1.0 - row[f"{metric}_after"] / row[f"{metric}_world"] for row in rows]
        outcome.seconds = round(time.perf_counter() - began, 2)
    return outcome

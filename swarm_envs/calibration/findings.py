"""The answer: what a world gets wrong about a log, which effects explain it, the extended world, and how much it gains."""

from __future__ import annotations

import json
import math
import warnings
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from swarm_envs.calibration.apply_effects import apply_effects
from swarm_envs.calibration.contact.identification import identify_contact
from swarm_envs.calibration.drive.identification import Identified, identify
from swarm_envs.calibration.logs.log import Log
from swarm_envs.calibration.logs.reading import read_log
from swarm_envs.calibration.residual.criticism import Discrepancy, criticise
from swarm_envs.calibration.residual.residual_dynamics import ResidualDynamics, find_residual_dynamics
from swarm_envs.calibration.residual.residuals import residuals
from swarm_envs.calibration.selection.causes import Cause
from swarm_envs.calibration.sensor.identification import identify_sensor
from swarm_envs.calibration.validation.gain import Gain
from swarm_envs.calibration.validation.heldout import heldout_gain
from swarm_envs.calibration.validation.swarm import swarm_gain
from swarm_envs.worlds import WorldSpec, load_world

LARGEST = 3
"""Discrepancies reported for each channel."""


@dataclass(frozen=True)
class Findings:
    """What calibration found; :meth:`to_json` has the schema of ``findings.json``."""

    spec: WorldSpec
    """The world that was calibrated."""
    log: Log
    """The data."""
    discrepancies: tuple[Discrepancy, ...]
    """Where the world's prediction departs from what was measured, and on what that depends."""
    causes: tuple[Cause, ...]
    """The effects that explain it."""
    indistinguishable: tuple[tuple[str, ...], ...]
    """Groups of effects that these data cannot tell apart."""
    rejected: tuple[tuple[str, float], ...]
    """Effects that were tried and not named, with their p-values."""
    unexplained: Discrepancy | None
    """The largest dependence that is left with all named effects, if any is certain."""
    residual_dynamics: ResidualDynamics | None
    """That dependence as smooth functions, where correcting it predicts held-out runs better."""
    gain: tuple[Gain, ...]
    """Before and after, on held-out runs."""
    extended: WorldSpec
    """The world with the effects."""
    identified: Identified
    """The fitted models, for whoever wants to look closer."""
    notes: tuple[str, ...]
    """Sentences that a reader should know."""

    @property
    def unlisted(self) -> ResidualDynamics | None:
        """Deprecated name of :attr:`residual_dynamics`."""
        warnings.warn("Findings.unlisted is called residual_dynamics", DeprecationWarning, stacklevel=2)
        return self.residual_dynamics

    def to_json(self) -> str:
        """Return the content of ``findings.json``; residual dynamics keep their first name there, ``unlisted``."""
        causes = [
            {
                "effect": cause.effect,
                "parameters": {
                    name: {"estimate": number.estimate, "ci95": list(number.ci95), "unit": number.unit}
                    for name, number in cause.parameters.items()
                },
                "heldout_gain": cause.heldout_gain,
                "p_value": cause.p_value,
                "explanation": cause.explanation,
            }
            for cause in self.causes
        ]
        unexplained = None if self.unexplained is None else asdict(self.unexplained)
        document: dict[str, Any] = {
            "world": self.spec.name,
            "data": {"name": self.log.name, "runs": len(self.log.runs), "robots": len(self.log.robots), "notes": list(self.notes)},
            "discrepancies": [asdict(entry) for entry in self.discrepancies],
            "causes": causes,
            "indistinguishable": [list(group) for group in self.indistinguishable],
            "rejected": [{"effect": name, "p_value": p} for name, p in self.rejected],
            "unexplained": unexplained,
            "unlisted": None if self.residual_dynamics is None else self.residual_dynamics.to_document(),
            "gain": [asdict(entry) for entry in self.gain],
            "extended_world": "extended.yaml",
        }
        return json.dumps(_finite(document), indent=2) + "\n"


def calibrate(log: str | Path | Log, world: str | Path | WorldSpec, progress: Callable[[str], None] = lambda text: None) -> Findings:
    """Find what a world gets wrong about a log, and why.

    Args:
        log: A log or its folder.
        world: A world's name, YAML file or spec.
        progress: Called with a line at each step.

    Raises:
        LogError: When the log cannot be read, or has nothing to predict.
        WorldError: When there is no such world.
    """
    spec = load_world(world)
    log = read_log(log) if isinstance(log, str | Path) else log
    found = identify(log, spec, progress)
    rest = find_residual_dynamics(log, found)
    found = found if rest is None else rest.remaining(found)
    seen = identify_sensor(log, spec, found, progress)
    touched = identify_contact(log, apply_effects(spec, found.causes, log.name), progress)
    causes = (*found.causes, *seen.causes, *touched.causes)
    wrong = criticise(residuals(log, found.start, found.robots))
    left = criticise(residuals(log, found.model, found.robots))
    extended = apply_effects(spec, causes, log.name)
    gain = heldout_gain(log, found.data, found.start.parameters, found.without, spec, extended)
    gain += swarm_gain(log, found.data, found.without, spec, extended, progress)
    notes = list(log.notes)
    if found.gains_first:
        notes.insert(0, "Commands are not in SI units, or far from them: gains were fitted first.")
    return Findings(
        spec=spec, log=log, discrepancies=tuple(_largest(wrong)), causes=causes,
        indistinguishable=(*found.indistinguishable, *seen.indistinguishable, *touched.indistinguishable),
        rejected=(*found.rejected, *seen.rejected, *touched.rejected), residual_dynamics=rest,
        unexplained=rest.discrepancy if rest is not None else left[0] if left else None, gain=tuple(gain),
        extended=extended, identified=found, notes=tuple(notes),
    )  # fmt: skip


def _largest(entries: list[Discrepancy]) -> list[Discrepancy]:
    """Keep the first few of each channel."""
    kept: list[Discrepancy] = []
    for entry in entries:
        if sum(other.channel == entry.channel for other in kept) < LARGEST:
            kept.append(entry)
    return kept


def _finite(node: Any) -> Any:
    """Replace what JSON cannot hold by null."""
    if isinstance(node, dict):
        return {key: _finite(value) for key, value in node.items()}
    if isinstance(node, list | tuple):
        return [_finite(value) for value in node]
    return None if isinstance(node, float) and not math.isfinite(node) else node

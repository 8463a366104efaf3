"""Replays in the report: a run three times side by side, as measured and as both worlds predict it."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.findings import Findings
from swarm_envs.calibration.report.markup import escaped
from swarm_envs.calibration.report.replays import STEP, Replay

HEADING_MARK, SMALLEST = 1.6, 60
"""Length in radii of the line that shows a robot's heading, and the least radii along a side, as in report.js."""


def player(replay: Replay, findings: Findings) -> str:
    """Return a replay's figure, which report.js plays."""
    outline, radius = findings.log.outline, findings.extended.robots[0].body.contact_radius
    left, bottom, side = view(replay, outline, radius)
    content = {
        "step": STEP, "left": round(left, 4), "bottom": round(bottom, 4), "side": round(side, 4), "radius": radius, "outline": outline,
        "measured": _paths(replay.measured, replay.missing), "before": _paths(replay.before), "after": _paths(replay.after),
    }  # fmt: skip
    names = {"measured": "measured", "before": f"{findings.spec.name}, before", "after": "calibrated, after"}
    panels = "".join(
        f'<div><div class="{kind}">{escaped(name)}</div>'
        f'<canvas class="{kind}" data-path="{kind}" role="img" aria-label="{escaped(replay.run)}: path {escaped(name)}"></canvas></div>'
        for kind, name in names.items()
    )
    last = len(replay.measured) - 1
    return (
        f'<figure class="replay"><figcaption>{escaped(replay.run)}</figcaption><div class="panels">{panels}</div>'
        f'<div class="controls"><button type="button">Play</button><input type="range" min="0" max="{last}" value="{last}" '
        f'aria-label="time in the run"><output></output></div>'
        f'<script type="application/json">{json.dumps(content, separators=(",", ":"))}</script></figure>'
    )


def view(replay: Replay, outline: Sequence[tuple[float, float]] | None, radius: float) -> tuple[float, float, float]:
    """Return the left and bottom edge and the side in m of a square in which every robot is seen whole.

    A predicted path is followed as far as the measured ones reach on either side: a world that is far off must not make all else tiny.
    """
    measured = replay.measured[..., :2][replay.missing == 0]
    known = measured if outline is None else np.vstack([measured, np.array(outline)])
    low, high = known.min(axis=0), known.max(axis=0)
    reach = float((high - low).max())
    predicted = np.concatenate([path[..., :2].reshape(-1, 2) for path in (replay.before, replay.after)])
    followed = np.vstack([known, np.clip(predicted, low - reach, high + reach)])
    low, high = followed.min(axis=0), followed.max(axis=0)
    extent = float((high - low).max())
    side = 1.02 * max(extent + 2 * HEADING_MARK * radius, extent / (1.0 - 2 * HEADING_MARK / SMALLEST))
    left, bottom = 0.5 * (low + high) - 0.5 * side
    return float(left), float(bottom), side


def _paths(poses: FloatArray, missing: FloatArray | None = None) -> list[list[list[float] | None]]:
    """Return each robot's poses to the millimetre and milliradian; None where it was not seen."""
    rounded = np.round(poses, 3)
    return [
        [None if missing is not None and missing[k, i] else [float(v) for v in rounded[k, i]] for k in range(len(poses))]
        for i in range(poses.shape[1])
    ]

"""The figures of the page."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from docs.studies.calibration_of_real_robots.step_responses import response, steps
from docs.studies.calibration_of_real_robots.tables import ROBOTS
from swarm_envs.calibration import Findings
from swarm_envs.calibration.drive.motion import free_run

Array = npt.NDArray[np.float64]
BEFORE, AFTER = "#d55e00", "#0072b2"
STEP = 0.05
"""Time in s between the points of a step response."""


def step_figure(findings: Findings) -> Any:
    """Return the mean response to starts and stops, measured and as both models have it."""
    from matplotlib.figure import Figure

    after = np.arange(-0.3, 1.5 + STEP / 2, STEP)
    figure = Figure(figsize=(8.4, 3.4), layout="constrained")
    for axis, starts in zip(figure.subplots(1, 2, sharey=True), (True, False), strict=True):
        found = [step for step in steps(findings.log) if step.starts == starts]
        paths: dict[str, list[Array]] = {"measured": [], "before": [], "calibrated": []}
        for step in found:
            paths["measured"].append(response(step, step.track.poses, after))
            for name, model in (("before", findings.identified.start), ("calibrated", findings.identified.model)):
                run = free_run(model.parameters, step.track).from_pose(0, step.track.poses[0], slice(None))
                paths[name].append(response(step, run, after))
        for name, colour, style in (("measured", "black", "-"), ("before", BEFORE, "--"), ("calibrated", AFTER, "-")):
            rows = np.array(paths[name])
            mean, error = rows.mean(axis=0), 1.96 * rows.std(axis=0, ddof=1) / np.sqrt(len(rows))
            axis.plot(after[:-1] + STEP / 2, mean, style, color=colour, label=name, lw=1.5)
            if name == "measured":
                axis.fill_between(after[:-1] + STEP / 2, mean - error, mean + error, color="0.75", lw=0)
        axis.set(xlabel="time since the command / s", title=f"{len(found)} {'starts' if starts else 'stops'}")
        if starts:
            axis.set_ylabel("forward speed / commanded")
    figure.legend(*axis.get_legend_handles_labels(), loc="outside right upper")
    return figure


def horizon_figure(every: Sequence[Findings]) -> Any:
    """Return the errors by horizon of all robots, before and after, and the trackers' noise."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.4, 5.2), layout="constrained")
    axes = figure.subplots(2, len(every), sharex=True, sharey="row")
    for column, findings in enumerate(every):
        for axis, metric in zip(axes[:, column], ("position", "heading"), strict=True):
            part = [gain for gain in findings.gain if gain.metric == metric and gain.horizon_s is not None]
            horizons = [gain.horizon_s for gain in part]
            axis.plot(horizons, [gain.before for gain in part], "o-", color=BEFORE, label="before")
            axis.plot(horizons, [gain.after for gain in part], "s-", color=AFTER, label="calibrated, held-out runs")
            axis.plot(horizons, [gain.noise_floor for gain in part], ":", color="black", label="tracker's noise")
            axis.set_yscale("log")
            axis.set_xticks([1, 5, 10])
        axes[0, column].set_title(ROBOTS[findings.log.name])
        axes[1, column].set_xlabel("horizon / s")
    axes[0, 0].set_ylabel("position error, rms / m")
    axes[1, 0].set_ylabel("heading error, rms / rad")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper left", ncols=3)
    return figure

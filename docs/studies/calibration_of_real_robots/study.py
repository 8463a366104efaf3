"""Numbers and figures of the page, from measured logs that are no part of the project.

``make study-calibration_of_real_robots ARGS=FOLDER`` or ``python -m docs.studies.calibration_of_real_robots FOLDER`` calibrates the logs
``hero_2018``, ``epuck_2018`` and ``create_2009`` in a folder, each against the world ``hero`` with an ideal drive, and writes the tables
between the page's markers and the figures beside it. With ``--leave-one-out`` each is calibrated again without each of its runs.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from docs.studies.marked_page import write_between_marks
from swarm_envs import load_world, rollouts
from swarm_envs.behaviours import label
from swarm_envs.calibration import Findings, Log, Track, calibrate
from swarm_envs.calibration.drive.motion import free_run
from swarm_envs.calibration.validation.leave_one_out import Stability, leave_one_out

Array = npt.NDArray[np.float64]

ROBOTS = {"hero_2018": "HeRo", "epuck_2018": "e-puck", "create_2009": "iRobot Create"}
PAGE = Path(__file__).with_name("index.md")
BEFORE, AFTER = "#d55e00", "#0072b2"
IDEAL = load_world("hero").with_effects(linear_gain=1.0, dead_time=0.0)
STEP = 0.05
"""Time in s between the points of a step response."""


# steps of the commanded speed


class Step(NamedTuple):
    """A change of the commanded forward speed between rest and motion, straight ahead, held for 1.5 s at least."""

    track: Track
    at: float
    """s"""
    speed: float
    """m/s or the driver's, that is started or stopped."""
    starts: bool


def steps(log: Log) -> Iterator[Step]:
    """Yield a log's starts and stops."""
    for track in log.tracked:
        times = np.append(track.command_times, track.times[-1])
        commands = np.vstack([np.zeros(2), track.commands])
        for k, (old, new) in enumerate(pairwise(commands)):
            if (old[0] == 0) != (new[0] == 0) and not old[1] and not new[1] and times[k + 1] - times[k] >= 1.5:
                yield Step(track, float(times[k]), float(new[0] or old[0]), bool(new[0] != 0))


def response(step: Step, path: Array, after: Array) -> Array:
    """Return the forward speed over the commanded one, in the middles of the intervals between ``after`` (K + 1,) s after the command."""
    at = np.clip(step.at + after, step.track.times[0], step.track.times[-1])
    x, y, heading = (np.interp(at, step.track.times, path[:, k]) for k in range(3))
    ahead = heading[len(at) // 2]
    along = np.diff(x) * np.cos(ahead) + np.diff(y) * np.sin(ahead)
    return np.asarray(along / np.diff(after) / step.speed)


def turns(log: Log) -> Iterator[Step]:
    """Yield a log's changes of the commanded turn rate, after 0.5 s and before 0.25 s of steady commands."""
    for track in log.tracked:
        times, rates = np.append(track.command_times, track.times[-1]), np.append(0.0, track.commands[:, 1])
        for k, (old, new) in enumerate(pairwise(rates)):
            before = times[k] - (times[k - 1] if k else track.times[0])
            if old != new and before >= 0.5 and times[k + 1] - times[k] >= 0.25:
                yield Step(track, float(times[k]), float(new - old), bool(new != 0))


def onset(step: Step, turning: bool = False) -> float:
    """Return the time in s from a command to the bend in the robot's way or heading, by least squares of two lines over -0.5 to 0.2 s.

    NaN where two lines do not fit: the tracker flipped.
    """
    inside = (step.track.times > step.at - 0.5) & (step.track.times < step.at + 0.2)
    t, poses = step.track.times[inside] - step.at, step.track.poses[inside]
    ahead = np.median(poses[:, 2])
    way = poses[:, 2] if turning else poses[:, :2] @ np.array([np.cos(ahead), np.sin(ahead)])

    def misfit(bend: float) -> float:
        lines = np.column_stack([np.ones_like(t), np.minimum(t, bend), np.maximum(t - bend, 0)])
        return float(np.mean((lines @ np.linalg.lstsq(lines, way, rcond=None)[0] - way) ** 2))

    candidates = np.arange(-0.05, 0.19, 0.002)
    misfits = [misfit(bend) for bend in candidates]
    return float(candidates[np.argmin(misfits)]) if np.sqrt(min(misfits)) < 0.05 else float("nan")


def interval(given: Sequence[float]) -> str:
    """Return the mean and its 95 % interval by Student's t; NaN is left out."""
    from scipy.stats import t

    values = np.array(given)[np.isfinite(given)]
    half = t.ppf(0.975, len(values) - 1) * values.std(ddof=1) / np.sqrt(len(values))
    return f"{values.mean():.3f} ({values.mean() - half:.3f} to {values.mean() + half:.3f})"


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


# all robots


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


def plain(value: float | None) -> str:
    """Return a number in m or rad as mm or mrad, to three digits."""
    if value is None:
        return ""
    return f"{1e3 * value:,.0f}" if value >= 0.1 else f"{1e3 * value:.3g}"


def gain_table(every: Sequence[Findings]) -> str:
    """Return errors before and after, by robot and horizon."""
    lines = [
        "| robot | error | horizon | before | calibrated | gain, 95 % interval | reference | tracker's noise |",
        "|---|---|---|---|---|---|---|---|",
    ]
    lines += [
        f"| {ROBOTS[findings.log.name]} | {gain.metric}, {'mm' if gain.unit == 'm' else 'mrad'} | {gain.horizon_s:g} s "
        f"| {plain(gain.before)} | {plain(gain.after)} | {plain(gain.ci95[0])} to {plain(gain.ci95[1])} | {plain(gain.reference)} "
        f"| {plain(gain.noise_floor)} |"
        for findings in every
        for gain in findings.gain
    ]
    return "\n".join(lines)


def cause_table(every: Sequence[Findings], stability: dict[str, Stability]) -> str:
    """Return the effects named, with their numbers, and how these move when runs are left out."""
    lines = [
        "| robot | effect | number | 95 % interval | with a run left out | named without a run |",
        "|---|---|---|---|---|---|",
    ]
    for findings in every:
        known = stability.get(findings.log.name)
        moved = {(entry.effect, entry.parameter): entry for entry in known.moved} if known else {}
        for cause in findings.causes:
            for name, number in cause.parameters.items():
                unit = "" if number.unit == "1" else f" {number.unit}"
                range_ = moved.get((cause.effect, name))
                times = f"{known.named[cause.effect]} of {known.runs}" if known else ""
                lines.append(
                    f"| {ROBOTS[findings.log.name]} | `{cause.effect}` {name} | {number.estimate:.3g}{unit} "
                    f"| {number.ci95[0]:.3g} to {number.ci95[1]:.3g} | {f'{range_.least:.3g} to {range_.most:.3g}' if range_ else ''} "
                    f"| {times} |"
                )
        if known:
            others = [f"`{name}` {times} of {known.runs}" for name, times in known.named.items() if name not in known.from_all]
            if others:
                lines.append(f"| {ROBOTS[findings.log.name]} | not named from all runs, but without one: {', '.join(others)} | | | | |")
    return "\n".join(lines)


def rest_table(every: Sequence[Findings]) -> str:
    """Return what cannot be told apart and what is left, by robot."""
    lines = ["| robot | runs | cannot be told apart | still unexplained |", "|---|---|---|---|"]
    for findings in every:
        groups = "; ".join(", ".join(f"`{name}`" for name in group) for group in findings.indistinguishable)
        left = findings.unexplained
        text = "nothing certain" if left is None else f"{left.channel} by {left.depends_on}, {left.size:.2g} {left.unit} rms"
        lines.append(f"| {ROBOTS[findings.log.name]} | {len(findings.log.runs)} | {groups} | {text} |")
    return "\n".join(lines)


def onset_table(findings: Findings) -> str:
    """Return the delays of HeRo's starts and stops, one by one."""
    log = findings.log
    kinds = {
        "starts": [onset(step) for step in steps(log) if step.starts],
        "stops": [onset(step) for step in steps(log) if not step.starts],
        "turn commands": [onset(step, turning=True) for step in turns(log)],
    }
    peak, steady = (
        [response(step, step.track.poses, np.array(span))[0] for step in steps(findings.log) if step.starts]
        for span in ((0.1, 0.2), (0.5, 1.5))
    )
    lines = ["| HeRo | steps | mean (95 % interval) |", "|---|---|---|"]
    lines += [f"| delay of {name}, s | {np.isfinite(values).sum()} | {interval(values)} |" for name, values in kinds.items()]
    lines += [f"| speed over commanded, 0.1 to 0.2 s after a start | {len(peak)} | {interval(peak)} |"]
    lines += [f"| speed over commanded, 0.5 to 1.5 s after a start | {len(steady)} | {interval(steady)} |"]
    return "\n".join(lines)


def label_table(controllers: int = 400) -> str:
    """Return how many runs of uniform controllers change their label with HeRo's dead time, and with another start."""
    delay = load_world("hero").robots[0].effects.dead_time
    lines = ["| world | labels that a dead time changes | that another seed changes |", "|---|---|---|"]
    for name in ("hero_plus", "hero"):
        world = load_world(name).with_effects(dead_time=0.0, linear_gain=1.0)
        limits = np.array([world.limits.linear_speed, world.limits.angular_speed] * 2)
        genes = np.random.default_rng(0).uniform(-1, 1, (controllers, 4)) * limits
        base, late, other = (
            label(rollouts(spec, genes, seed=seed, record_every=5))
            for spec, seed in ((world, 1), (world.with_effects(dead_time=delay), 1), (world, 2))
        )
        shares = [np.mean([a != b for a, b in zip(base, labels, strict=True)]) for labels in (late, other)]
        lines.append(f"| `{name}` | {shares[0]:.1%} | {shares[1]:.1%} |")
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> None:
    """Calibrate, and write the page's tables and figures."""
    parser = argparse.ArgumentParser(
        prog="python -m docs.studies.calibration_of_real_robots", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="folder with the measured logs")
    parser.add_argument("--leave-one-out", action="store_true", help="calibrate again without each run")
    options = parser.parse_args(arguments)
    every, stability = [], {}
    for name in ROBOTS:
        begin = time.process_time()
        findings = calibrate(options.folder / name, IDEAL)
        print(
            f"{name}: {', '.join(cause.effect for cause in findings.causes)} ({time.process_time() - begin:.0f} s)",
            file=sys.stderr,
            flush=True,
        )
        every.append(findings)
        if options.leave_one_out:
            stability[name] = leave_one_out(findings.log, IDEAL, findings.causes, lambda text: print(text, file=sys.stderr, flush=True))
    tables = {
        "gain": gain_table(every), "causes": cause_table(every, stability), "rest": rest_table(every), "onset": onset_table(every[0]),
        "labels": label_table(),
    }  # fmt: skip
    write_between_marks(PAGE, tables)
    horizon_figure(every).savefig(PAGE.with_name("horizons.png"), dpi=90)
    step_figure(every[0]).savefig(PAGE.with_name("hero_steps.png"), dpi=90)

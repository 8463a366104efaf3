"""The tables of the page, as Markdown."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from docs.studies.calibration_of_real_robots.step_responses import onset, response, steps, turns
from swarm_envs import load_world, rollouts
from swarm_envs.behaviours import label
from swarm_envs.calibration import Findings
from swarm_envs.calibration.validation.leave_one_out import Stability

ROBOTS = {"hero_2018": "HeRo", "epuck_2018": "e-puck", "create_2009": "iRobot Create"}
"""Robots by the name of their log."""


def interval(given: Sequence[float]) -> str:
    """Return the mean and its 95 % interval by Student's t; NaN is left out."""
    from scipy.stats import t

    values = np.array(given)[np.isfinite(given)]
    half = t.ppf(0.975, len(values) - 1) * values.std(ddof=1) / np.sqrt(len(values))
    return f"{values.mean():.3f} ({values.mean() - half:.3f} to {values.mean() + half:.3f})"


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

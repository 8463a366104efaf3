"""``report.html``: wrong here, because of this, now predicted so. One file that needs no other."""

from __future__ import annotations

import json
from collections.abc import Sequence
from importlib import resources
from pathlib import Path

import numpy as np

from swarm_envs.calibration.findings import Findings
from swarm_envs.calibration.report.figures import discrepancy_figure, horizon_figure
from swarm_envs.calibration.report.markup import escaped, estimate, p_value, quantity, table
from swarm_envs.calibration.report.player import player
from swarm_envs.calibration.report.replays import replays
from swarm_envs.calibration.residual.criticism import Discrepancy
from swarm_envs.calibration.residual.residuals import residuals
from swarm_envs.calibration.selection.causes import Cause
from swarm_envs.calibration.validation.gain import Gain
from swarm_envs.calibration.validation.leave_one_out import Stability
from swarm_envs.worlds.dump import world_to_text

EXPERIMENTS = {
    frozenset({"dead_time", "clock_offset"}): (
        "record when a robot's own detections or encoders change, on the clock of the commands: late wheels are late there too, "
        "a shifted tracker is not"
    ),
}
"""What would separate effects that these data cannot."""
LOOKED_AT = (
    Discrepancy("forward speed", "commanded speed", 0.0, "m/s", 1.0),
    Discrepancy("turn rate", "commanded turn rate", 0.0, "rad/s", 1.0),
)
"""What is drawn where no dependence is certain by itself."""
VARY = "repeat the drives with speeds, turns, pauses and starts varied independently of each other"


def write_folder(findings: Findings, folder: Path, stability: Stability | None = None) -> None:
    """Write ``findings.json``, ``extended.yaml``, ``report.html`` and, if given, ``stability.json`` to a folder, made if absent."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "findings.json").write_text(findings.to_json(), encoding="utf-8")
    (folder / "extended.yaml").write_text(world_to_text(findings.extended), encoding="utf-8")
    (folder / "report.html").write_text(page(findings, stability), encoding="utf-8")
    if stability is not None:
        (folder / "stability.json").write_text(json.dumps(stability.to_document(), indent=2) + "\n", encoding="utf-8")


def page(findings: Findings, stability: Stability | None = None) -> str:
    """Return the report."""
    title = f"What {findings.spec.name} gets wrong about {findings.log.name}"
    style, script = (resources.files(__package__).joinpath(f"report.{kind}").read_text("utf-8") for kind in ("css", "js"))
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{escaped(title)}</title><style>{style}</style></head><body><main><h1>{escaped(title)}</h1>"
        f"{_summary(findings)}{_wrong(findings)}{_because(findings)}{_stable(stability)}{_now(findings)}{_replays(findings)}{_data(findings)}"
        f"</main><script>{script}</script></body></html>\n"
    )


# the argument


def _summary(findings: Findings) -> str:
    furthest = {gain.metric: gain for gain in findings.gain if gain.horizon_s is not None}
    cards = "".join(
        f'<li>{metric} after {gain.horizon_s:g} s, held out<b><span class="before">{quantity(gain.before, gain.unit)}</span> → '
        f'<span class="after">{quantity(gain.after, gain.unit)}</span></b>{_improvement(gain)}</li>'
        for metric, gain in furthest.items()
    )
    named = ", ".join(cause.effect for cause in findings.causes) or "no effect"
    cards += f"<li>named<b>{len(findings.causes)} effect{'s' if len(findings.causes) != 1 else ''}</b>{escaped(named)}</li>"
    runs, robots = len(findings.log.runs), len(findings.log.robots)
    return (
        f"<p>{runs} run{'s' if runs != 1 else ''} of {robots} robot{'s' if robots != 1 else ''}. Predictions start at a measured pose and "
        f'see nothing but the commands. <span class="before">Before</span> is the world as it was, <span class="after">after</span> with '
        f'the effects named below, fitted to other runs than those that are predicted.</p><ul class="cards">{cards}</ul>'
    )


def _improvement(gain: Gain) -> str:
    low, high = gain.ci95
    if low > 0:
        return f"better by {quantity(low, gain.unit)} to {quantity(high, gain.unit)}, 95 %"
    return f"change between {quantity(low, gain.unit)} and {quantity(high, gain.unit)}, 95 %: not certain"


def _wrong(findings: Findings) -> str:
    found = findings.identified
    before, after = (residuals(findings.log, model, found.robots) for model in (found.start, found.model))
    rows = [(entry.channel, _depends(entry), quantity(entry.size, entry.unit), p_value(entry.p_value)) for entry in findings.discrepancies]
    picture = discrepancy_figure(before, after, findings.discrepancies or LOOKED_AT)
    lead = (
        "Where the measured motion departs from the predicted one, the largest first."
        if rows
        else "With these runs no dependence is certain by itself, whatever explains it; this is how forward speed and turn rate depart."
    )
    figure = (
        f'<figure><div class="scroll">{picture}</div><figcaption>Measured minus predicted motion over windows of half a second: means of '
        "windows alike in what it depends on, with 95 % intervals. A right world lies on zero.</figcaption></figure>"
        if picture
        else ""
    )
    return f"<h2>Wrong here</h2><p>{lead}</p>{figure}{table(('channel', 'depends on', 'size, rms', 'p'), rows)}"


def _depends(entry: Discrepancy) -> str:
    return "nothing: the same everywhere" if entry.depends_on == "nothing" else entry.depends_on


def _because(findings: Findings) -> str:
    if findings.causes:
        head = ("effect", "what it does", "parameters, 95 % interval", "gain on held-out runs", "p")
        named = table(head, [_cause(cause) for cause in findings.causes])
    else:
        named = "<p>No effect is significant.</p>"
    groups = "".join(
        f"<li>{escaped(' or '.join(group))}. To separate them: {_separating(group)}.</li>" for group in findings.indistinguishable
    )
    alike = f"<h3>What these data cannot tell apart: confounded effects</h3><ul>{groups}</ul>" if groups else ""
    left = findings.unexplained
    rest = (
        "<p>No certain departure is left.</p>" if left is None
        else f"<p>Unexplained: the {escaped(left.channel)} still depends on {escaped(_depends(left))}, "
        f"{quantity(left.size, left.unit)} rms, p {p_value(left.p_value)}.</p>"
    )  # fmt: skip
    rest += _residual_dynamics(findings)
    tried = ", ".join(f"{name} (p {p_value(p)})" for name, p in findings.rejected)
    rejected = f"<details><summary>Tried and not named</summary><p>{escaped(tried)}</p></details>" if tried else ""
    return f"<h2>Because of this</h2>{named}{alike}{rest}{rejected}"


def _residual_dynamics(findings: Findings) -> str:
    rest = findings.residual_dynamics
    if rest is None or not rest.heldout:
        return ""
    end = rest.heldout[-1]
    place = f"from {quantity(end.position_before, 'm')} to {quantity(end.position_after, 'm')}"
    heading = f"from {quantity(end.heading_before, 'rad')} to {quantity(end.heading_after, 'rad')}"
    instead = f" They take the place of {escaped(', '.join(rest.instead_of))}." if rest.instead_of else ""
    return (
        "<p>The residual dynamics as a function of that (<code>unlisted</code> in findings.json) take the error after "
        f"{end.horizon_s:g} s on held-out runs {place} and {heading}.{instead}</p>"
    )


def _cause(cause: Cause) -> tuple[str, ...]:
    numbers = "; ".join(
        f"{name} = {estimate(v.estimate, v.unit)} [{v.ci95[0]:.4g}, {v.ci95[1]:.4g}]" for name, v in cause.parameters.items()
    )
    gain = "fitted first" if np.isnan(cause.heldout_gain) else f"{cause.heldout_gain:.0f} nats"
    return cause.effect, cause.explanation, numbers, gain, p_value(cause.p_value)


def _separating(group: Sequence[str]) -> str:
    return next((text for pair, text in EXPERIMENTS.items() if pair <= set(group)), VARY)


def _stable(stability: Stability | None) -> str:
    if stability is None:
        return ""
    counts = [
        (name, f"{times} of {stability.runs}", "yes" if name in stability.from_all else "no") for name, times in stability.named.items()
    ]
    moved = [
        (f"{m.effect}, {m.parameter}", estimate(m.estimate, m.unit), f"{estimate(m.least, m.unit)} to {estimate(m.most, m.unit)}",
         f"{estimate(m.ci95[0], m.unit)} to {estimate(m.ci95[1], m.unit)}")
        for m in stability.moved
    ]  # fmt: skip
    return (
        f"<h3>With runs left out one at a time</h3><p>{'The same effects are named each time.' if stability.stable else ''}</p>"
        + table(("effect", "named", "named from all runs"), counts)
        + table(("parameter", "all runs", "without one", "95 % interval"), moved)
    )


def _now(findings: Findings) -> str:
    windows = [gain for gain in findings.gain if gain.horizon_s is not None]
    swarm = [gain for gain in findings.gain if gain.horizon_s is None]
    picture = horizon_figure(windows)
    figure = (
        f'<figure><div class="scroll">{picture}</div><figcaption>Error at the end of free-running windows on runs that the model was not '
        "fitted to. Intervals in the table: runs with turns and runs without, resampled among themselves. "
        "The reference is a regression that knows no mechanics.</figcaption></figure>"
        if picture
        else ""
    )
    head = ("metric", "before", "after", "gain, 95 % interval", "noise floor", "reference")
    text = f"<h2>Now predicted so</h2>{figure}" + table(head, [_gain(gain) for gain in windows])
    if swarm:
        text += (
            "<h3>Whole swarms</h3><p>Errors over whole runs of all robots together: the commands replayed from the first poses, and "
            "(closed loop) the controllers run on simulated readings. For labels and detections: the share that differs.</p>"
            + table(head[:-1], [_gain(gain)[:-1] for gain in swarm])
        )
    return text


def _gain(gain: Gain) -> tuple[str, ...]:
    when = "" if gain.horizon_s is None else f" after {gain.horizon_s:g} s"
    floor, reference = ("" if value is None else quantity(value, gain.unit) for value in (gain.noise_floor, gain.reference))
    name = gain.metric.replace("closed_loop.", "closed loop, ").replace("_", " ")
    interval = f"{quantity(gain.ci95[0], gain.unit)} to {quantity(gain.ci95[1], gain.unit)}"
    return name + when, quantity(gain.before, gain.unit), quantity(gain.after, gain.unit), interval, floor, reference


def _replays(findings: Findings) -> str:
    found = findings.identified
    shown = replays(findings.log, found.data, found.without, findings.spec, findings.extended)
    players = "".join(player(replay, findings) for replay in shown)
    return f"<h2>See for yourself</h2><p>Whole runs, simulated from the first pose by the commands alone.</p>{players}" if players else ""


def _data(findings: Findings) -> str:
    notes = "".join(f"<li>{escaped(note)}</li>" for note in findings.notes)
    return (
        f"<h2>Data and use</h2>{f'<ul>{notes}</ul>' if notes else ''}"
        "<p>The calibrated world is <code>extended.yaml</code>, all numbers are in <code>findings.json</code>:</p>"
        '<pre>import gymnasium as gym\nimport swarm_envs\n\nenv = gym.make("HeRo/Swarm-v0", world="extended.yaml")</pre>'
    )

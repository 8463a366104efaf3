"""``report.html``: wrong here, because of this, now predicted so. One file that needs no other."""

from __future__ import annotations

import base64
import html
import io
from pathlib import Path
from typing import Any

import numpy as np

from swarm_envs.calibration.criticism import CHANNELS, Residuals, residuals
from swarm_envs.calibration.drive import free_run
from swarm_envs.calibration.findings import Findings
from swarm_envs.calibration.prediction import tracked
from swarm_envs.worlds.dump import world_to_text

BEFORE, AFTER, MEASURED = "#d55e00", "#0072b2", "#000000"
"""Colours that survive colour blindness."""
STYLE = (
    "body{font:16px/1.5 sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem}table{border-collapse:collapse}"
    "td,th{padding:.2rem .8rem;border-bottom:1px solid #ccc;text-align:left}img{max-width:100%}"
)


def write_folder(findings: Findings, folder: Path) -> None:
    """Write ``findings.json``, ``extended.yaml`` and ``report.html``."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "findings.json").write_text(findings.to_json(), encoding="utf-8")
    (folder / "extended.yaml").write_text(world_to_text(findings.extended), encoding="utf-8")
    (folder / "report.html").write_text(page(findings), encoding="utf-8")


def page(findings: Findings) -> str:
    """Return the report."""
    found = findings.identified
    before, after = (residuals(findings.log, model, found.robots) for model in (found.start, found.model))
    causes = "".join(
        f"<li><b>{html.escape(cause.effect)}</b>: {html.escape(cause.explanation)}<br>"
        + "; ".join(f"{n} = {v.estimate:.4g} [{v.ci95[0]:.4g}, {v.ci95[1]:.4g}] {v.unit}" for n, v in cause.parameters.items())
        + f". On held-out runs it gains {cause.heldout_gain:.0f} nats, p = {cause.p_value:.1g}.</li>"
        for cause in findings.causes
    )
    groups = "".join(f"<li>{html.escape(', '.join(group))}{_separating(group)}</li>" for group in findings.indistinguishable)
    left = findings.unexplained
    rest = (
        "<p>No certain departure is left.</p>" if left is None
        else f"<p>Unexplained: {left.channel} depends on {left.depends_on}, {left.size:.3g} {left.unit} rms, p = {left.p_value:.1g}.</p>"
    )  # fmt: skip
    return (
        f"<!doctype html><meta charset=utf-8><title>{html.escape(findings.log.name)}</title><style>{STYLE}</style>"
        f"<h1>What {html.escape(findings.world)} gets wrong about {html.escape(findings.log.name)}</h1>"
        f"<p>{len(findings.log.runs)} runs of {len(findings.log.robots)} robots.</p>"
        f"{''.join(f'<p>{html.escape(note)}</p>' for note in findings.notes)}"
        f"<h2>Wrong here</h2>{_table(('channel', 'depends on', 'size', 'unit', 'p'), _discrepancies(findings))}"
        f"{_image(residual_figure(before, after))}"
        f"<h2>Because of this</h2><ul>{causes or '<li>No effect is significant.</li>'}</ul>"
        f"{f'<p>These data cannot tell apart:</p><ul>{groups}</ul>' if groups else ''}{rest}"
        f"<h2>Now predicted so</h2>{_table(('metric', 'horizon', 'before', 'after', 'gain, 95 %', 'noise floor'), _gains(findings))}"
        f"<p>Runs that were held out: each is predicted by a model fitted to others.</p>{_image(path_figure(findings))}"
    )


def _separating(group: tuple[str, ...]) -> str:
    if set(group) == {"dead_time", "clock_offset"}:
        return ": record when a robot's own detections or encoders change, on the commands' clock; late wheels are late there too"
    return ": repeat the drives with speeds, turns and pauses varied independently of each other"


def _discrepancies(findings: Findings) -> list[tuple[str, ...]]:
    return [(d.channel, d.depends_on, f"{d.size:.3g}", d.unit, f"{d.p_value:.1g}") for d in findings.discrepancies]


def _gains(findings: Findings) -> list[tuple[str, ...]]:
    return [
        (g.metric, f"{g.horizon_s:g} s", f"{g.before:.4g} {g.unit}", f"{g.after:.4g} {g.unit}", f"[{g.ci95[0]:.3g}, {g.ci95[1]:.3g}]",
         f"{g.noise_floor:.2g} {g.unit}")
        for g in findings.gain
    ]  # fmt: skip


def _table(head: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    cells = "".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{''.join(f'<th>{cell}</th>' for cell in head)}</tr>{cells}</table>"


def _image(figure: Any) -> str:
    stream = io.BytesIO()
    figure.savefig(stream, format="png", dpi=80, bbox_inches="tight")
    return f'<p><img alt="" src="data:image/png;base64,{base64.b64encode(stream.getvalue()).decode()}"></p>'


def residual_figure(before: Residuals, after: Residuals) -> Any:
    """Return a figure of each channel's error against each circumstance."""
    from matplotlib.figure import Figure

    names = [name for name in before.circumstances if name not in ("place", "robot")]
    figure = Figure(figsize=(3 * max(1, len(names)), 7), layout="constrained")
    axes = figure.subplots(len(CHANNELS), max(1, len(names)), squeeze=False, sharey="row")
    for row, (channel, unit) in enumerate(CHANNELS.items()):
        for column, name in enumerate(names):
            for found, colour, label in ((before, BEFORE, "before"), (after, AFTER, "after")):
                axes[row, column].plot(found.circumstances[name], found.errors[:, row], ".", ms=2, color=colour, label=label)
            axes[row, column].axhline(0, color=MEASURED, lw=0.5)
            axes[-1, column].set_xlabel(name)
        axes[row, 0].set_ylabel(f"{channel}\nmeasured - predicted / {unit}")
    if names:
        figure.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside upper right", markerscale=5)
    return figure


def path_figure(findings: Findings, most: int = 6) -> Any:
    """Return a figure of measured paths beside those that both models drive from the first pose, by the commands alone."""
    from matplotlib.figure import Figure

    found = findings.identified
    tracks = tracked(findings.log)[:most]
    figure = Figure(figsize=(12, 4 * -(-len(tracks) // 3)), layout="constrained")
    axes = np.ravel(figure.subplots(-(-len(tracks) // 3), 3, squeeze=False))
    for axis in axes[len(tracks) :]:
        axis.axis("off")
    for axis, track in zip(axes, tracks, strict=False):
        axis.plot(*track.poses[:, :2].T, color=MEASURED, lw=2, label="measured")
        for model, colour, label in ((found.start, BEFORE, "before"), (found.model, AFTER, "after")):
            run = free_run(model.parameters, track, model.gains[found.robots.index(track.robot)])
            axis.plot(*run.from_pose(0, track.poses[0], slice(None))[:, :2].T, color=colour, lw=1, label=label)
        axis.set(title=f"{track.run}, {track.robot}", xlabel="x / m", ylabel="y / m")
        reach = np.ptp(track.poses[:, :2], axis=0).max() * 0.75 + 0.1
        middle = 0.5 * (track.poses[:, :2].min(axis=0) + track.poses[:, :2].max(axis=0))
        axis.set(xlim=(middle[0] - reach, middle[0] + reach), ylim=(middle[1] - reach, middle[1] + reach), aspect="equal")
    figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper right")
    return figure

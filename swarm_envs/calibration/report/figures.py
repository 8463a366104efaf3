"""Figures of a calibration as SVG that takes the page's text colour, for pages light and dark."""

from __future__ import annotations

import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.residual.criticism import Discrepancy
from swarm_envs.calibration.residual.residuals import CHANNELS, Residuals
from swarm_envs.calibration.validation.gain import Gain

BEFORE, AFTER = "#d55e00", "#0072b2"
"""Colours that survive colour blindness, on white and on black."""
INK = "#010203"
"""Stands for the page's text colour; nothing else is drawn in it."""
BINS = 8
"""Groups of equally many windows along a variable."""
PANELS = 6
"""Discrepancies shown at most."""
UNITS = {"time since a start": "s", "time in the run": "s", "heading": "rad"}
"""Units of the covariates in which a channel may err."""
RC: Any = {
    "svg.fonttype": "none", "font.family": "sans-serif", "font.size": 11, "text.color": INK, "axes.edgecolor": INK, "axes.labelcolor": INK,
    "xtick.color": INK, "ytick.color": INK, "axes.spines.top": False, "axes.spines.right": False, "figure.facecolor": "none",
    "axes.facecolor": "none", "legend.frameon": False,
}  # fmt: skip


@dataclass(frozen=True)
class Binned:
    """Means of groups of windows that are alike in one covariate."""

    centres: FloatArray
    """(B,) mean covariate."""
    means: FloatArray
    """(B,) mean error."""
    half_widths: FloatArray
    """(B,) half the 95 % interval of the mean."""


def binned(values: FloatArray, errors: FloatArray, bins: int = BINS) -> Binned:
    """Return the mean error of groups of about equally many windows; few distinct values have a group each."""
    order = np.argsort(values, kind="stable")
    distinct = np.unique(np.round(values, 6))
    if len(distinct) <= bins:
        groups = [np.flatnonzero(np.round(values, 6) == value) for value in distinct]
    else:
        edges = np.unique(np.quantile(values, np.linspace(0, 1, bins + 1)[1:-1]))
        label = np.searchsorted(edges, values[order], side="right")
        groups = [order[label == k] for k in range(len(edges) + 1)]
    kept = [group for group in groups if len(group) >= 3]
    return Binned(
        np.array([values[group].mean() for group in kept]), np.array([errors[group].mean() for group in kept]),
        np.array([1.96 * errors[group].std(ddof=1) / np.sqrt(len(group)) for group in kept]),
    )  # fmt: skip


def svg(figure: Any, label: str) -> str:
    """Return a figure as an SVG element that a screen reader names ``label``."""
    import matplotlib as mpl

    stream = io.StringIO()
    # ids are salted with the label: several figures live in one page
    with mpl.rc_context({**RC, "svg.hashsalt": label}):
        figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None}, transparent=True)
    text = stream.getvalue()
    text = text[text.index("<svg") :].replace(INK, "currentColor")
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = re.sub(r' (?:width|height)="[\d.]+pt"', "", text, count=2)
    name = label.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
    return text.replace("<svg", f'<svg role="img" aria-label="{name}"', 1)


def discrepancy_figure(before: Residuals, after: Residuals, entries: Sequence[Discrepancy]) -> str:
    """Return a small plot for each of the largest dependences: mean error with its interval, before and after."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    shown = [entry for entry in entries if entry.depends_on in before.covariates][:PANELS]
    if not shown:
        return ""
    columns = min(3, len(shown))
    rows = -(-len(shown) // columns)
    with mpl.rc_context(RC):
        figure = Figure(figsize=(3.4 * columns, 2.9 * rows + 0.4), layout="constrained")
        axes = np.ravel(figure.subplots(rows, columns, squeeze=False))
        for axis in axes[len(shown) :]:
            axis.axis("off")
        for axis, entry in zip(axes, shown, strict=False):
            row = list(CHANNELS).index(entry.channel)
            for found, colour, label, shape in ((before, BEFORE, "before", "o"), (after, AFTER, "after", "s")):
                values = found.covariates[entry.depends_on]
                means = binned(values, found.errors[:, row], 16 if entry.depends_on in ("place", "robot") else BINS)
                axis.errorbar(
                    means.centres, means.means, means.half_widths, fmt=f"{shape}-", color=colour, ms=4, lw=1, capsize=2, label=label
                )
            axis.axhline(0, color=INK, lw=0.6)
            unit = UNITS.get(entry.depends_on)
            axis.set_xlabel(entry.depends_on + (f" / {unit}" if unit else ""))
            axis.set_ylabel(f"{entry.channel} / {entry.unit}")
        figure.legend(*axes[0].get_legend_handles_labels(), loc="outside upper left", ncols=2)
    names = "; ".join(f"{entry.channel} by {entry.depends_on}" for entry in shown)
    return svg(figure, f"Measured minus predicted motion, mean and 95 % interval, before and after: {names}")


def horizon_figure(gains: Sequence[Gain]) -> str:
    """Return the error by horizon, before and after, above the tracker's noise floor; empty without windows."""
    import matplotlib as mpl
    from matplotlib.figure import Figure

    parts = [[gain for gain in gains if gain.metric == metric and gain.horizon_s is not None] for metric in ("position", "heading")]
    if not all(parts):
        return ""
    with mpl.rc_context(RC):
        figure = Figure(figsize=(8.4, 3.4), layout="constrained")
        for axis, part in zip(figure.subplots(1, 2), parts, strict=True):
            horizons = np.array([gain.horizon_s for gain in part], float)
            was, now = np.array([gain.before for gain in part]), np.array([gain.after for gain in part])
            axis.plot(horizons, was, "o-", color=BEFORE, label="before")
            axis.plot(horizons, now, "s-", color=AFTER, label="after")
            floors = np.array([np.nan if gain.noise_floor is None else gain.noise_floor for gain in part], float)
            axis.plot(horizons, floors, ":", color=INK, label="tracker's noise")
            reference = np.array([np.nan if gain.reference is None else gain.reference for gain in part], float)
            if np.isfinite(reference).any():
                axis.plot(horizons, reference, "x--", color=INK, lw=0.8, label="reference without mechanics")
            lowest = np.nanmin(np.concatenate([was, now, floors]))
            axis.set(yscale="log", ylim=(0.5 * lowest, None), xlabel="horizon / s", ylabel=f"{part[0].metric} error, rms / {part[0].unit}")
            axis.set_xticks(horizons)
        figure.legend(*axis.get_legend_handles_labels(), loc="outside upper left", ncols=4)
    text = "; ".join(f"{g.metric} after {g.horizon_s:g} s from {g.before:.3g} to {g.after:.3g} {g.unit}" for part in parts for g in part)
    return svg(figure, f"Error by horizon on held-out runs, before and after: {text}")

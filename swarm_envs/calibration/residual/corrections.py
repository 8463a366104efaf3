"""Corrections of a drive's velocities: what they are proportional to, what they depend on, and their values along a path."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from swarm_envs.calibration.arrays import FloatArray, IntArray
from swarm_envs.calibration.residual.residuals import CHANNELS, Residuals

FORWARD, LATERAL, TURN = range(3)
REGRESSORS = {
    FORWARD: ("speed", "any motion"),
    LATERAL: ("speed", "turn rate", "any motion"),
    TURN: ("distance", "speed", "turn rate", "any motion"),
}
"""What the corrections of a channel may be proportional to: forward speed, its amount, turn rate, or nothing."""
COVARIATES = ("heading", "commanded speed", "commanded turn rate", "time since a start", "time in the run", "robot", "place")
"""What a correction may depend on, simplest first."""
PERIODIC, ONE_BY_ONE, PLANE = "heading", "robot", "place"


def kernel(coordinates: FloatArray, centres: FloatArray, width: float, *, edges: bool = False) -> FloatArray:
    """Return how alike a function is at coordinates (W, D) and centres (M, D): (W, M); a function with edges may bend anywhere."""
    squared = (coordinates**2).sum(axis=1)[:, None] + (centres**2).sum(axis=1) - 2.0 * coordinates @ centres.T
    squared = np.maximum(squared, 0.0) / width**2
    return np.asarray(np.exp(-np.sqrt(squared)) if edges else np.exp(-0.5 * squared))


@dataclass(frozen=True)
class Basis:
    """Functions of a covariate whose ridge regression is that of a Gaussian process, and a constant."""

    depends_on: str
    centres: FloatArray
    """(M, D) in the covariate's coordinates: m over the arena, a unit circle for headings, else s, m/s or rad/s."""
    width: float
    """Length over which the function changes, in the same."""
    mixed: FloatArray
    """(M, K) makes kernels at the centres into functions that are as likely as each other."""

    def __call__(self, coordinates: FloatArray) -> FloatArray:
        """Return the functions' values (W, K + 1) at coordinates (W, D)."""
        edges = self.depends_on == PLANE
        return np.column_stack([kernel(coordinates, self.centres, self.width, edges=edges) @ self.mixed, np.ones(len(coordinates))])

    def weighed(self, coordinates: FloatArray, weights: FloatArray) -> FloatArray:
        """Return the correction (W,) at coordinates (W, D) for weights (Q,), or (W, Q) if each has its own."""
        return weighted_sum(self(coordinates), weights)

    @classmethod
    def at(cls, depends_on: str, centres: FloatArray, width: float) -> Basis:
        """Return the basis with these centres."""
        values, vectors = np.linalg.eigh(kernel(centres, centres, width, edges=depends_on == PLANE))
        return cls(depends_on, centres, width, vectors / np.sqrt(np.maximum(values, 1e-6 * values.max())))


def weighted_sum(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Return the sums (W,) of values (W, Q) times weights (Q,), or (W, Q) if each row has its own."""
    return np.asarray(values @ weights if weights.ndim == 1 else np.einsum("wm,wm->w", values, weights))


@dataclass(frozen=True)
class Covariates:
    """Where W robots are, how they move and what they were told."""

    pose: FloatArray
    """(W, 3) m, m, rad: the robot's heading, not the marker's."""
    motion: FloatArray
    """(W, 2) forward speed in m/s and turn rate in rad/s, as the listed effects have them."""
    command: FloatArray
    """(W, 2) in force."""
    since: FloatArray
    """(W,) s since the last start from rest."""
    time: FloatArray
    """(W,) s since the start of the run."""
    robot: FloatArray
    """(W,) index."""

    def coordinates(self, name: str) -> FloatArray:
        """Return the coordinates (W, D) of a covariate."""
        if name == PLANE:
            return self.pose[:, :2]
        if name == PERIODIC:
            return np.column_stack([np.cos(self.pose[:, 2]), np.sin(self.pose[:, 2])])
        values = {
            "commanded speed": self.command[:, 0], "commanded turn rate": self.command[:, 1], "time since a start": self.since,
            "time in the run": self.time, "robot": self.robot,
        }  # fmt: skip
        return np.asarray(values[name][:, None], float)

    def regressor(self, name: str) -> FloatArray:
        """Return what a correction is proportional to (W,)."""
        return regressor(name, self.motion)


def regressor(name: str, motion: FloatArray) -> FloatArray:
    """Return what a correction is proportional to (...,) for motions (..., 2)."""
    v, omega = motion[..., 0], motion[..., 1]
    if name == "any motion":
        return np.asarray((np.abs(v) > 1e-3) | (np.abs(omega) > 1e-2), float)
    return np.asarray({"speed": v, "distance": np.abs(v), "turn rate": omega}[name])


def covariates_of(found: Residuals) -> Covariates:
    """Return the covariates of windows."""
    c = found.covariates
    return Covariates(
        np.column_stack([found.where, c["heading"]]), found.motion, np.column_stack([c["commanded speed"], c["commanded turn rate"]]),
        c["time since a start"], c["time in the run"], c["robot"],
    )  # fmt: skip


@dataclass(frozen=True)
class Term:
    """One correction: its regressor times a function of what it depends on is added to a channel."""

    channel: int
    regressor: str
    basis: Basis
    weights: FloatArray
    """(Q,) fitted to all runs."""
    without: FloatArray
    """(G, Q) for each held-out group those fitted without its fold."""

    def __call__(self, at: Covariates, weights: FloatArray | None = None) -> FloatArray:
        """Return the correction (W,) of the channel in m/s or rad/s; ``weights`` (W, Q) if each has its own."""
        given = self.basis.weighed(at.coordinates(self.basis.depends_on), self.weights if weights is None else weights)
        return np.asarray(at.regressor(self.regressor) * given)

    def to_document(self) -> dict[str, Any]:
        """Return the correction on a grid: its value for each unit of what it is proportional to."""
        name, centres = self.basis.depends_on, self.basis.centres
        if name == PERIODIC:
            grid = np.linspace(0, 2 * np.pi, 25)
            coordinates = np.column_stack([np.cos(grid), np.sin(grid)])
            points: list[Any] = grid.tolist()
        elif name == PLANE:
            coordinates, points = centres, centres.tolist()
        else:
            coordinates = centres if name == ONE_BY_ONE else np.linspace(centres.min(), centres.max(), 25)[:, None]
            points = coordinates[:, 0].tolist()
        channel = list(CHANNELS)[self.channel]
        return {
            "channel": channel, "depends_on": name, "proportional_to": self.regressor, "unit": CHANNELS[channel], "at": points,
            "value": self.basis.weighed(coordinates, self.weights).tolist(),
        }  # fmt: skip


def corrections(terms: Sequence[Term], at: Covariates, group: IntArray | None) -> FloatArray:
    """Return the corrections (W, 3) of all channels; ``group`` (W,) for those fitted without each one's group."""
    result = np.zeros((len(at.time), len(CHANNELS)))
    for term in terms:
        result[:, term.channel] += term(at, None if group is None else term.without[group])
    return result

"""Departures that are on nobody's list: what a calibration must call unexplained."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Extra = Callable[[Array, Array, Array, Array, Array], tuple[Array, Array]]
"""(v, omega, x, y, theta) of all robots at an instant to the (v, omega) that they then have."""


def slippery_patch(random: np.random.Generator) -> Extra:
    """Forward speed falls by 40 to 60 % inside a disc of radius 0.3 to 0.4 m near the middle of the drives."""
    x0, y0 = random.uniform(-0.15, 0.15, 2)
    radius, share = random.uniform(0.3, 0.4), random.uniform(0.4, 0.6)

    def patch(v: Array, omega: Array, x: Array, y: Array, theta: Array) -> tuple[Array, Array]:
        return np.where((x - x0) ** 2 + (y - y0) ** 2 < radius**2, v * share, v), omega

    return patch


def magnetic_stripe(random: np.random.Generator) -> Extra:
    """A stripe along y, 0.25 m wide, turns a robot that drives in it by 3 to 6 rad/m, always the same way."""
    x0 = random.uniform(-0.15, 0.15)
    bend = random.choice([-1, 1]) * random.uniform(3, 6)

    def stripe(v: Array, omega: Array, x: Array, y: Array, theta: Array) -> tuple[Array, Array]:
        return v, np.where(np.abs(x - x0) < 0.125, omega + bend * np.abs(v), omega)

    return stripe


def heading_speed(random: np.random.Generator) -> Extra:
    """Speed depends on the heading, as on a slope: v (1 + a cos theta), a from 0.15 to 0.35."""
    swing = random.uniform(0.15, 0.35)

    def slope(v: Array, omega: Array, x: Array, y: Array, theta: Array) -> tuple[Array, Array]:
        return v * (1 + swing * np.cos(theta)), omega

    return slope


UNLISTED: dict[str, Callable[[np.random.Generator], Extra]] = {
    "slippery_patch": slippery_patch,
    "magnetic_stripe": magnetic_stripe,
    "heading_speed": heading_speed,
}

"""The law of a binary sensor: what is in view, and how likely a reading is wrong, as pure functions on numbers and a robot's effects.

The simulation draws from these probabilities and calibration weighs readings by them; neither has a formula of its own for either. What
is in view calibration knows with the noise of measured poses only, which :mod:`swarm_envs.calibration.sensor.likelihood` adds to the
sector's edges.
"""

from __future__ import annotations

from swarm_envs.compiled import compiled
from swarm_envs.worlds import Effects


@compiled(forceinline=True, _nrt=False)
def meets_sector(along: float, across: float, cos_half: float, sin_half: float, reach: float, radius: float) -> bool:
    """Whether a disc meets a sensor's sector and has its centre in range.

    Args:
        along: Centre's coordinate along the sector's axis in m.
        across: Absolute value of its coordinate across the axis in m.
        cos_half: Cosine of the sector's half-angle.
        sin_half: Sine of the sector's half-angle.
        reach: Range in m.
        radius: Of the disc in m.
    """
    # signed distance from the line of the edge ray, positive outside the sector: the disc is never nearer than that
    outside = across * cos_half - along * sin_half
    squared = along * along + across * across
    # where the centre lies behind the edge ray's start: inside a sector wider than a half-plane, else only the apex can be met
    ahead = along * cos_half + across * sin_half >= 0.0
    behind = ((cos_half < 0.0) & (outside <= 0.0)) | (squared <= radius * radius)
    return (outside <= radius) & (squared <= reach * reach) & (ahead | behind)


@compiled(_nrt=False)
def miss_probability(effects: Effects, share: float, v: float, omega: float) -> float:
    """Return the probability that a reading misses what is in view; 1 or more is certainty.

    Args:
        effects: The robot's.
        share: Distance of the nearest robot in view, as a share of the sensor's range.
        v: Driven, in m/s.
        omega: Driven, in rad/s.
    """
    return (
        effects.missed_detections
        + effects.misses_at_full_range * share * share
        + effects.misses_when_turning * abs(omega)
        + effects.misses_when_driving * abs(v)
    )


@compiled(_nrt=False)
def false_probability(effects: Effects) -> float:
    """Return the probability that a reading with nothing in view reports a robot."""
    return effects.false_detections

"""How likely readings are wrong, by the sensor's law: the simulation draws from the same probabilities."""

from __future__ import annotations

from collections.abc import Sequence

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.compiled import compiled
from swarm_envs.simulation.sensor_law import false_probability, miss_probability
from swarm_envs.worlds import Effects


@compiled(_nrt=False)
def miss_probabilities(rows: Sequence[Effects], share: FloatArray, v: FloatArray, omega: FloatArray, out: FloatArray) -> None:
    """Write the probability that each of D readings misses what is in view.

    Args:
        rows: (1,) the robot's effects, see :func:`swarm_envs.simulation.effect_rows.effect_rows`.
        share: (D,) distance of the nearest robot in view, as a share of the sensor's range.
        v: (D,) driven, in m/s.
        omega: (D,) driven, in rad/s.
        out: (D,) written.
    """
    for n in range(share.shape[0]):
        out[n] = miss_probability(rows[0], share[n], v[n], omega[n])


@compiled(_nrt=False)
def false_detection_probability(rows: Sequence[Effects]) -> float:
    """Return the probability that a reading with nothing in view reports a robot; ``rows`` (1,) are the robot's effects."""
    return false_probability(rows[0])

"""Which effects of the sensor explain a log's detections."""

from __future__ import annotations

from collections.abc import Callable

from swarm_envs.calibration.drive.identification import Identified
from swarm_envs.calibration.logs.log import Log
from swarm_envs.calibration.selection.causes import NOTHING, Named
from swarm_envs.calibration.selection.forward import ForwardSelection, Rules
from swarm_envs.calibration.sensor.candidates import EFFECTS, NOISE_SCALE
from swarm_envs.calibration.sensor.likelihood import SensorLikelihood
from swarm_envs.calibration.sensor.views import Readings
from swarm_envs.worlds import WorldSpec

ENOUGH = 100
"""Readings without which nothing is said about the sensor."""
RULES = Rules(most=4, examined=2, tried=len(EFFECTS), label="sensor: ")


def identify_sensor(log: Log, world: WorldSpec, drive: Identified, progress: Callable[[str], None] = lambda text: None) -> Named:
    """Name the effects of the sensor that explain a log's detections.

    Args:
        log: The log.
        world: Its first robot's first sensor is what the log is compared with.
        drive: What explains the log's drives: speeds, turn rates and the tracker's noise.
        progress: Called with a line at each step.
    """
    readings = Readings(log, drive.model, drive.robots)
    if len(readings.views(0.0).detected) < ENOUGH or readings.most < 2:
        return NOTHING
    likelihood = SensorLikelihood(readings, world, drive.model.noise)
    start = likelihood.fit(likelihood.base, [NOISE_SCALE])
    return likelihood.named(ForwardSelection(likelihood, start, RULES, progress).run())

"""Measured-like logs in which a known departure from the ideal robot is hidden.

Written from the definitions of the effects alone, on a time step of its own (1 ms) and sharing no code with the simulation
or the calibration that it puts to the test: a mistake made in both would have to be made twice.
"""

from docs.studies.calibration.generator.log import drawn_extra, generate_log, robot_gains
from docs.studies.calibration.generator.ranges import EFFECTS, EffectRange, draw
from docs.studies.calibration.generator.unlisted import UNLISTED

__all__ = ["EFFECTS", "UNLISTED", "EffectRange", "draw", "drawn_extra", "generate_log", "robot_gains"]

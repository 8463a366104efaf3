"""How many runs of a log drive where an effect of place acts, and how many where it does not.

With a single run beside a patch, that run cannot be predicted from the others: whatever is fitted to those, the floor is the same
everywhere. So the share of an error that a correction can remove on held-out runs depends on these numbers, not on the method alone.
"""

from __future__ import annotations

import numpy as np

from docs.studies.calibration.generator.unlisted import Extra
from swarm_envs.calibration.logs.log import Log, tracked

LEAST = 1.0
"""Time in s for which a run must drive on a side."""
MOVING = 0.015
"""Speed in m/s above which a robot drives."""
EVERY = 0.1
"""Time in s between the moments that are looked at."""


def runs_on_either_side(log: Log, extra: Extra) -> tuple[int, int]:
    """Return the numbers of runs that drive where an effect does not act, and where it does.

    Args:
        log: The log.
        extra: The effect.
    """
    seconds: dict[str, np.ndarray] = {}
    for track in tracked(log):
        times = np.arange(track.times[0], track.times[-1], EVERY)
        x, y, theta = (np.interp(times, track.times, column) for column in track.poses.T)
        drives = np.hypot(np.gradient(x), np.gradient(y)) > MOVING * EVERY
        one = np.ones_like(x)
        v, omega = extra(one, np.zeros_like(x), x, y, theta)
        acts = (v != one) | (omega != 0.0)
        sides = EVERY * np.array([np.sum(drives & ~acts), np.sum(drives & acts)])
        seconds[track.run] = seconds.get(track.run, np.zeros(2)) + sides
    beside, on = (np.array(list(seconds.values())) >= LEAST).sum(axis=0)
    return int(beside), int(on)

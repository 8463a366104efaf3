"""Which numbers of contact explain how robots push each other and scrape along walls."""

from __future__ import annotations

from collections.abc import Callable

from swarm_envs.calibration.contact.candidates import EFFECTS
from swarm_envs.calibration.contact.likelihood import ContactLikelihood
from swarm_envs.calibration.contact.windows import Windows, contact_windows
from swarm_envs.calibration.logs.log import Log
from swarm_envs.calibration.selection.causes import NOTHING, Named
from swarm_envs.calibration.selection.forward import ForwardSelection, Rules
from swarm_envs.calibration.selection.likelihood import Fitted
from swarm_envs.worlds import WorldSpec
from swarm_envs.worlds.errors import WorldError

# each number acts in contacts of its own, so that none makes another needless
RULES = Rules(most=len(EFFECTS), examined=1, tried=len(EFFECTS), always_all=True, eliminates=False, label="contact: ")


def identify_contact(log: Log, world: WorldSpec, progress: Callable[[str], None] = lambda text: None) -> Named:
    """Name the numbers of contact that differ from a world's.

    Args:
        log: The log.
        world: What it is compared with; the drive's effects that were named before act in it.
        progress: Called with a line at each step.
    """
    windows = contact_windows(log)
    if windows is None or (log.outline is None and windows.start.shape[1] < 2):
        return NOTHING
    try:
        return _identified(log, world, windows, progress)
    except WorldError:
        # an arena of the log that no world can have; its drives and detections stand without it
        return NOTHING


def _identified(log: Log, world: WorldSpec, windows: Windows, progress: Callable[[str], None]) -> Named:
    likelihood = ContactLikelihood(log, world, windows)
    start = Fitted(likelihood.base, likelihood.log_likelihood(likelihood.base))
    return likelihood.named(ForwardSelection(likelihood, start, RULES, progress).run())

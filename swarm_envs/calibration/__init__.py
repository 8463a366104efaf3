"""From measured logs to a better world: what the simulation gets wrong, which effect explains it, and how much is gained.

:func:`calibrate` needs ``swarm-envs[calibration]``; reading and predicting logs do not.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from swarm_envs.calibration.errors import LogError
from swarm_envs.calibration.logs.log import Log, Track
from swarm_envs.calibration.logs.reading import read_log
from swarm_envs.calibration.prediction.evaluation import evaluate

if TYPE_CHECKING:
    from swarm_envs.calibration.findings import Findings, calibrate

__all__ = ["Findings", "Log", "LogError", "Track", "calibrate", "evaluate", "read_log"]


def __getattr__(name: str) -> Any:
    """Import what needs scipy on first use."""
    if name in ("Findings", "calibrate"):
        from swarm_envs.calibration import findings

        return getattr(findings, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")

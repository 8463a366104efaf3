"""From measured logs to a better world: what the simulation gets wrong, which effect explains it, and how much is gained."""

from swarm_envs.calibration.errors import LogError
from swarm_envs.calibration.log import Log, Track, read_log
from swarm_envs.calibration.prediction import evaluate

__all__ = ["Log", "LogError", "Track", "evaluate", "read_log"]

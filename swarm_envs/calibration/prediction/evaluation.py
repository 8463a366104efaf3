"""How well a world predicts a log: free-running windows, inside the log's arena where its walls are known."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

import numpy as np

from swarm_envs.calibration.arrays import FloatArray
from swarm_envs.calibration.drive.parameters import drive_parameters
from swarm_envs.calibration.errors import LogError
from swarm_envs.calibration.logs.log import Log, Track, tracked
from swarm_envs.calibration.logs.reading import read_log
from swarm_envs.calibration.prediction.arena import arena_errors
from swarm_envs.calibration.prediction.windows import HORIZONS, WindowErrors, rms, window_errors
from swarm_envs.worlds import WorldSpec, load_world


def predictor(
    log: Log, world: WorldSpec, parameters: FloatArray, gains: Mapping[str, FloatArray] | None = None, runs: Iterable[str] | None = None
) -> Callable[[Track, float], WindowErrors]:
    """Return a function that gives the errors of a drive's prediction of a track at a horizon in s.

    Args:
        log: The log; with an outline, prediction knows walls and the other robots.
        world: Whose bodies and contact meet them.
        parameters: (P,) of the drive.
        gains: (2,) by robot, its own factors on both gains.
        runs: Only tracks of these runs will be asked for; all by default.
    """
    if log.outline is None:
        return lambda track, horizon: window_errors(parameters, track, horizon, None if gains is None else gains.get(track.robot))
    known = arena_errors(log, world, parameters, gains, runs)
    nothing = WindowErrors(np.empty(0), np.empty(0), np.empty(0))
    return lambda track, horizon: known[horizon].get((track.run, track.robot), nothing)


def evaluate(world: str | Path | WorldSpec, log: str | Path | Log) -> dict[str, dict[str, float]]:
    """Return how well a world predicts a log when nothing is fitted.

    Each window starts at a measured pose; the world's drive, its effects included, and the commands do the rest. Where the log gives
    the arena's outline, robots of a run are predicted together, and the walls and their bodies hold them up; elsewhere each drives
    alone on an open floor.

    Args:
        world: A world's name, YAML file or spec.
        log: A log or its folder.

    Returns:
        For each horizon (``"1.0"``, ``"5.0"``, ``"10.0"`` seconds) the rms at the window's end as ``position_m`` and
        ``heading_rad``, and the number of ``windows``. A horizon that no run reaches is left out.

    Raises:
        LogError: When the log cannot be read, or has nothing to predict.
        WorldError: When there is no such world.
    """
    spec = load_world(world)
    log = read_log(log) if isinstance(log, str | Path) else log
    tracks = tracked(log)
    predict = predictor(log, spec, drive_parameters(spec))
    result = {}
    for horizon in HORIZONS:
        errors = [predict(track, horizon) for track in tracks]
        position, heading = np.concatenate([e.position for e in errors]), np.concatenate([e.heading for e in errors])
        if len(position):
            result[f"{horizon:.1f}"] = {"position_m": rms(position), "heading_rad": rms(heading), "windows": len(position)}
    if not result:
        raise LogError(f"{log.name}: no run lasts {HORIZONS[0]} s with poses; nothing to predict")
    return result

"""Prediction inside an arena: what the drive alone would do, and what walls and the other robots of the run make of it.

The drive's motion is that of :mod:`swarm_envs.calibration.drive.motion`, command by command; the engine of the world holds it against the
walls of the log's outline and against the other robots, which are predicted together from their measured poses.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely

from swarm_envs.calibration.arrays import BoolArray, FloatArray, IntArray
from swarm_envs.calibration.drive.motion import FreeRun, free_run
from swarm_envs.calibration.errors import LogError
from swarm_envs.calibration.logs.log import Log, Track
from swarm_envs.calibration.prediction.windows import HORIZONS, NEAR, STRIDE, WindowErrors
from swarm_envs.simulation import Simulation
from swarm_envs.simulation.segments import distances_to_segments, polygon_edges
from swarm_envs.worlds import Effects, WorldError, WorldSpec

TICK = 0.05
"""Tick in s of the simulations; a stride of the windows is a whole number of them."""
OPEN_FLOOR = ((-1000.0, -1000.0), (1000.0, -1000.0), (1000.0, 1000.0), (-1000.0, 1000.0))
"""Corners in m of the square that stands for an arena without known walls."""
ASTRAY = 0.05
"""Largest share of poses that may lie outside the outline before it is held to be wrong."""
Errors = dict[float, dict[tuple[str, str], WindowErrors]]
"""By horizon in s, then by run and robot."""


@dataclass(frozen=True)
class Motion:
    """What R robots' drives do in each of T ticks of a run, without contact."""

    speed: FloatArray
    """(T, R, 2) m/s and rad/s."""
    drift: FloatArray
    """(T, R, 2) displacement by the floor's drift in m."""
    marker_yaw: float
    """Measured heading minus the robot's, in rad."""


def arena_world(world: WorldSpec, outline: Sequence[tuple[float, float]] | None, robots: int) -> WorldSpec:
    """Return a world's bodies and contact inside an outline, with a drive that does exactly what it is told.

    Raises:
        LogError: When no world can have the outline.
    """
    corners = OPEN_FLOOR if outline is None else tuple(outline)
    arena = dataclasses.replace(world.arena, outline=corners, obstacles=())
    ideal = dataclasses.replace(world.robots[0], effects=Effects())
    spec = world.replace(arena=arena, objects=(), broadcast=None, tick=TICK, robots=(ideal,) * robots, name="the log's arena")
    try:
        Simulation(spec, 0, "disc")
    except WorldError as error:
        raise LogError(f"outline: {error}; give its corners in order, in m, in the frame of the poses") from None
    return spec


def motion(
    parameters: FloatArray, tracks: Sequence[Track], begin: float, ticks: int, gains: Mapping[str, FloatArray] | None = None
) -> Motion:
    """Return what the drives of a run's robots do from a time in s on, by their commands alone.

    Args:
        parameters: (P,) of the drive.
        tracks: The robots of one run.
        begin: Time of the first tick's start.
        ticks: T.
        gains: (2,) by robot, its own factors on both gains.
    """
    grid = np.asarray(begin + TICK * np.arange(ticks + 1), np.float64)
    runs: list[FreeRun] = [
        free_run(parameters, dataclasses.replace(track, times=grid), None if gains is None else gains.get(track.robot)) for track in tracks
    ]
    path = np.stack([run.path for run in runs], axis=1)
    gone = np.diff(path, axis=0)
    half = 0.5 * gone[..., 2]
    middle = path[:-1, :, 2] + half
    chord = gone[..., 0] * np.cos(middle) + gone[..., 1] * np.sin(middle)
    v = chord / (np.sinc(half / np.pi) * TICK)
    return Motion(
        np.stack([v, gone[..., 2] / TICK], axis=-1), np.diff(np.stack([run.drift for run in runs], axis=1), axis=0),
        float(runs[0].marker_yaw),
    )  # fmt: skip


def replay(world: WorldSpec, moved: Motion, first: IntArray, start: FloatArray, ticks: int) -> FloatArray:
    """Return the poses (ticks + 1, W, R, 3) of W windows as a tracker would measure them.

    Args:
        world: From :func:`arena_world`.
        moved: What the drives do.
        first: (W,) tick at which each window starts.
        start: (W, R, 3) measured poses there.
        ticks: Length of the windows; past the end of ``moved`` robots stand.
    """
    yaw = np.array([0.0, 0.0, moved.marker_yaw])
    simulation = Simulation(world, len(first), "disc")
    simulation.poses[:] = start - yaw
    out = np.empty((ticks + 1, *start.shape))
    out[0] = start
    last = len(moved.speed) - 1
    for k in range(ticks):
        now = np.minimum(first + k, last)
        inside = (first + k <= last)[:, None, None]
        simulation.step(moved.speed[now] * inside)
        simulation.poses[..., :2] += moved.drift[now] * inside
        out[k + 1] = simulation.poses + yaw
    return out


def arena_errors(
    log: Log, world: WorldSpec, parameters: FloatArray, gains: Mapping[str, FloatArray] | None = None, runs: Iterable[str] | None = None
) -> Errors:
    """Return the errors at the ends of windows that start at the same times for all robots of a run.

    Args:
        log: With an outline.
        world: Its robots' bodies and its contact meet the walls.
        parameters: (P,) of the drive.
        gains: (2,) by robot, its own factors on both gains.
        runs: Only these runs; all by default.

    Raises:
        LogError: When poses lie outside the outline.
    """
    outline = np.array(log.outline)
    chosen = set(log.runs if runs is None else runs)
    found: Errors = {horizon: {} for horizon in HORIZONS}
    for run in log.runs:
        tracks = [track for track in log.tracked if track.run == run]
        if run not in chosen or not tracks:
            continue
        for track in tracks:
            _refuse_astray(log, track, outline)
        starts = np.arange(min(t.times[0] for t in tracks), max(t.times[-1] for t in tracks) - min(HORIZONS) + 1e-9, STRIDE)
        ticks = round(max(HORIZONS) / TICK)
        moved = motion(parameters, tracks, float(starts[0]), ticks + round(STRIDE / TICK) * len(starts), gains) if len(starts) else None
        there = np.array([_measured(track, starts) for track in tracks]).reshape(len(tracks), len(starts)).T
        pose = np.stack([at(track, starts) for track in tracks], axis=1)
        for present in np.unique(there, axis=0):
            kept = np.flatnonzero((there == present).all(axis=1))
            if moved is None or not present.any() or not len(kept):
                continue
            own = np.flatnonzero(present)
            part = Motion(moved.speed[:, own], moved.drift[:, own], moved.marker_yaw)
            spec = arena_world(world, log.outline, len(own))
            simulated = replay(spec, part, kept * round(STRIDE / TICK), pose[kept][:, own], ticks)
            for column, robot in enumerate(own):
                for horizon in HORIZONS:
                    errors = _errors(tracks[robot], starts[kept], horizon, simulated[round(horizon / TICK), :, column])
                    _add(found[horizon], tracks[robot], errors)
    return found


def at(track: Track, times: FloatArray) -> FloatArray:
    """Return the measured poses (K, 3) at some times, between measurements along a straight line."""
    return np.column_stack([np.interp(times, track.times, track.poses[:, k]) for k in range(3)])


def _measured(track: Track, times: FloatArray) -> BoolArray:
    """Return whether (K,) a pose was measured near each time."""
    after = np.clip(np.searchsorted(track.times, times), 1, len(track.times) - 1)
    return np.asarray(np.minimum(np.abs(track.times[after] - times), np.abs(track.times[after - 1] - times)) <= NEAR)


def _errors(track: Track, starts: FloatArray, horizon: float, predicted: FloatArray) -> WindowErrors:
    kept = _measured(track, starts + horizon)
    true = at(track, starts[kept] + horizon)
    gone = predicted[kept] - true
    return WindowErrors(starts[kept], np.hypot(gone[:, 0], gone[:, 1]), (gone[:, 2] + math.pi) % (2 * math.pi) - math.pi)


def _add(found: dict[tuple[str, str], WindowErrors], track: Track, errors: WindowErrors) -> None:
    key = (track.run, track.robot)
    if key in found:
        parts = [np.concatenate([getattr(found[key], field.name), getattr(errors, field.name)]) for field in dataclasses.fields(errors)]
        order = np.argsort(parts[0], kind="stable")
        errors = WindowErrors(*(part[order] for part in parts))
    found[key] = errors


def _refuse_astray(log: Log, track: Track, outline: FloatArray) -> None:
    places = track.poses[:, :2]
    outside = ~shapely.contains_xy(shapely.Polygon(outline), *places.T) & (
        distances_to_segments(np.ascontiguousarray(places), polygon_edges(outline)) > 0.01
    )
    if outside.mean() > ASTRAY:
        raise LogError(
            f"{log.name}: {outside.mean():.0%} of the poses of {track.robot} in {track.run} lie outside the outline; "
            "give its corners in the frame of the poses"
        )

"""Which readings come out otherwise in a world when its sensors look from the measured poses."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from swarm_envs.calibration.arrays import BoolArray, FloatArray, IntArray
from swarm_envs.calibration.drive.parameters import drive_parameters, with_drive
from swarm_envs.calibration.logs.log import Track
from swarm_envs.calibration.prediction.arena import TICK, arena_world, at, motion
from swarm_envs.calibration.validation.gain import Gain, bootstrap
from swarm_envs.calibration.validation.swarm_runs import SwarmRun
from swarm_envs.simulation import Simulation
from swarm_envs.worlds import WorldSpec


def detections_gain(runs: Sequence[SwarmRun], world: WorldSpec, extended: WorldSpec) -> list[Gain]:
    """Return the share of readings that come out otherwise when sensors look from the measured poses."""
    sums, chance = [], []
    for seed, run in enumerate(runs):
        if not all(len(track.detection_times) for track in run.tracks):
            continue
        calibrated = with_drive(extended, run.model.parameters)
        times = _reading_times(run, max(_sensor_delay(world), _sensor_delay(calibrated)))
        true = _reported(run, times)
        before = _simulated(run, times, world, drive_parameters(world), 2 * seed)
        after, again = (_simulated(run, times, calibrated, run.model.parameters, 2 * seed + number) for number in (0, 1))
        sums.append([(before != true).sum(), (after != true).sum(), len(true)])
        chance.append((again != after).mean())
    if not sums:
        return []
    array = np.array(sums, float)
    was, now = array[:, :2].sum(axis=0) / array[:, 2].sum()
    return [Gain("detections", None, "1", float(was), float(now), bootstrap(array, root=False), float(np.mean(chance)))]


def _sensor_delay(world: WorldSpec) -> float:
    return world.robots[0].effects.sensor_delay


def _reading_times(run: SwarmRun, delay: float) -> FloatArray:
    """Return the times (T,) of a run's readings, of those whose view was tracked though it is up to ``delay`` s old."""
    times = np.unique(np.round(np.concatenate([track.detection_times for track in run.tracks]), 3))
    return np.asarray(times[(times - delay >= run.begin) & (times <= run.begin + run.time[-1])])


def _own_readings(track: Track, times: FloatArray) -> tuple[IntArray, IntArray]:
    """Return the indices of a robot's readings at some times (T,), among its own readings and among the times."""
    own = np.round(track.detection_times, 3)
    kept = np.flatnonzero(np.isin(own, times))
    return kept, np.searchsorted(times, own[kept])


def _reported(run: SwarmRun, times: FloatArray) -> BoolArray:
    """Return the measured readings (D,) at some times, robot by robot."""
    return np.concatenate([track.detections[_own_readings(track, times)[0]] for track in run.tracks])


def _simulated(run: SwarmRun, times: FloatArray, world: WorldSpec, parameters: FloatArray, seed: int) -> BoolArray:
    """Return the readings (D,) that a world's sensors give at the measured poses at the same times."""
    robots = tuple(world.robots[k % world.num_robots] for k in range(len(run.tracks)))
    seeing = world.replace(robots=robots, broadcast=None, objects=()).with_effects(sensor_delay=0.0)
    # an arena counts only where it hides robots, which no log's outline is known to do
    spec = seeing.replace(arena=arena_world(seeing, None, len(robots)).arena)
    simulation = Simulation(spec, len(times), "disc")
    simulation.reset(seed)
    looked = times - _sensor_delay(world)
    simulation.poses[:] = np.stack([at(track, looked) for track in run.tracks], axis=1)
    ticks = round(run.time[-1] / TICK) + 1
    speed = motion(parameters, run.tracks, run.begin, ticks, run.gains).speed
    simulation.state.drive_velocity[:] = speed[np.clip(((looked - run.begin) / TICK).astype(int), 0, ticks - 1)]
    simulation.observe()
    readings = simulation.detections.reshape(len(times), len(robots), -1)[..., 0] > 0
    return np.concatenate([readings[_own_readings(track, times)[1], column] for column, track in enumerate(run.tracks)])

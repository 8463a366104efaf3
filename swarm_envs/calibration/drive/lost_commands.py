"""Which commands of a track seem to have been lost."""

from __future__ import annotations

import dataclasses

import numpy as np

from swarm_envs.calibration.drive.fitting import Model
from swarm_envs.calibration.drive.motion import command_delay, goal_at
from swarm_envs.calibration.drive.parameters import INDEX, as_drives
from swarm_envs.calibration.logs.log import Track


def without_lost_commands(track: Track, model: Model, robot: int) -> Track:
    """Return a track without the commands that seem to have been lost, where the model says that some are.

    What a lost command does is chance: left in, it would look like an error that depends on the command.
    """
    if model.parameters[INDEX["command_loss"]] <= 0.0 or not len(track.commands):
        return track
    drives, factors, kept = as_drives(model.parameters), model.gains[robot], []
    begins = track.command_times + command_delay(drives)
    ends = np.minimum(np.append(begins[1:], track.times[-1]), begins + 1.0)
    latched = (0.0, 0.0)
    for number, (v, omega) in enumerate(track.commands.tolist()):
        first, last = np.searchsorted(track.times, (begins[number], ends[number]))
        if (v, omega) != latched and 0 < first < last - 1 and last < len(track.times):
            span = track.times[last] - track.times[first]
            heading = 0.5 * (track.poses[first, 2] + track.poses[last, 2])
            gone = track.poses[last, :2] - track.poses[first, :2]
            moved = np.array([gone @ (np.cos(heading), np.sin(heading)), track.poses[last, 2] - track.poses[first, 2]]) / span
            # a rim's breadth makes speeds and turn rates alike
            misses = [
                np.abs((moved - goal_at(drives[0], factors, asked[0], asked[1], begins[number])) * (1.0, 0.05)).sum()
                for asked in ((v, omega), latched)
            ]
            if misses[1] < misses[0]:
                continue
        kept.append(number)
        latched = (v, omega)
    return dataclasses.replace(track, command_times=track.command_times[kept], commands=track.commands[kept])

"""Memory that a tick writes before it reads: nothing in it is carried from one tick or world to the next."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from swarm_envs.simulation.parameters import FloatArray

IntArray = npt.NDArray[np.int64]


class Scratch(NamedTuple):
    """Scratch memory for one world at a time (R robots, at most C contacts)."""

    columns: FloatArray
    """(5, R) one quantity of all robots side by side, so that a loop over robots takes several at once; see below."""
    contacts: FloatArray
    """(C, columns) the disc engine's contacts."""
    contact_pairs: IntArray
    """(C, 3) robot, then robot or R for a wall, then the wall's index, of each contact."""
    velocity: FloatArray
    """(R + 1, 3) vx, vy in m/s and omega in rad/s of the robots and, zero, of the walls."""
    commands: FloatArray
    """(R, 2) what a controller commands, v in m/s and omega in rad/s."""
    desired_velocity: FloatArray
    """(R, 3) velocities that the robots would have without contact."""
    assignment: IntArray
    """(R,) which solver a robot is assigned to: see the disc engine."""
    active_pass: IntArray
    """(R + 1,) number of the pass in which contact last moved each robot, 0 of the walls: see the disc engine."""


# Rows of Scratch.columns.
X, Y, EXTENT, COS, SIN = range(5)


def scratch_for(robots: int, contacts: int, width: int) -> Scratch:
    """Allocate scratch memory for so many robots and contacts of ``width`` numbers."""
    return Scratch(
        columns=np.zeros((5, robots)),
        contacts=np.zeros((contacts, width)),
        contact_pairs=np.zeros((contacts, 3), np.int64),
        velocity=np.zeros((robots + 1, 3)),
        commands=np.zeros((robots, 2)),
        desired_velocity=np.zeros((robots, 3)),
        assignment=np.zeros(robots, np.int64),
        active_pass=np.zeros(robots + 1, np.int64),
    )

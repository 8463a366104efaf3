"""How many substeps a tick needs, and how fast overlaps are to vanish in them."""

from __future__ import annotations

import math

from swarm_envs.compiled import compiled
from swarm_envs.simulation import parameters as p
from swarm_envs.simulation.chipmunk.prediction import DESIRED_X, SOLVED_X
from swarm_envs.simulation.contacts import robots_within, wall_within
from swarm_envs.simulation.parameters import FloatArray, WorldArrays, compile_world
from swarm_envs.worlds import WorldSpec

OVERLAP_HALF_LIFE = 1.0 / 60.0
"""Seconds in which half of an overlap is gone."""
MAX_CLOSING = 0.006
"""Two robots near each other may change their distance by at most this many metres in a substep; see :func:`substeps_needed`."""
WALL_SUBSTEPS = 2
"""Least substeps of a tick in which a robot may touch a wall: its heading turns."""
LATTICE = 100
"""A substep begins and ends on this lattice of a tick; one in which robots first touch ends on the next point after the touch."""
SUBSTEPS = (1, 2, 4, 5, 10, 20)
"""Allowed substeps: divisors of the drive's own lattice of pieces."""


def substeps_for(world: WorldSpec) -> int:
    """Return the substeps of a tick that keep the overlap of robots below 5 mm, for speeds up to 0.36 m/s at a tick of 0.1 s.

    Faster robots get the largest number there is and overlap more; the disc engine has no such limit.
    """
    closing = 2.0 * compile_world(world).reach
    return next((n for n in SUBSTEPS if closing / n <= MAX_CLOSING), SUBSTEPS[-1])


@compiled(forceinline=True, _nrt=False)
def substeps_needed(world: WorldArrays, poses: FloatArray, predicted: FloatArray, most: int) -> int:
    """Return the substeps of a tick, 0 where nothing is near enough to touch.

    Near pairs count with the fastest relative velocity they can have: either may be blocked by others, or no longer. So do robots past
    the end of a wall, whose touch is not predicted. A drive with effects gets ``most``: dead time, lag or a wheel that is freed change
    its speed inside the tick, and how it sets out tells nothing.
    """
    fastest, pair, wall = 0.0, False, False
    for i in range(poses.shape[0]):
        for j in range(i):
            if robots_within(world, poses, i, j, 2.0 * world.reach):
                pair = True
                for a in (DESIRED_X, SOLVED_X):
                    for b in (DESIRED_X, SOLVED_X):
                        vx, vy = predicted[j, b] - predicted[i, a], predicted[j, b + 1] - predicted[i, a + 1]
                        fastest = max(fastest, vx * vx + vy * vy)
        for e in range(world.walls.shape[0]):
            if wall_within(world, poses, i, e, 2.0 * world.reach):
                wall = True
                if beyond_end(world, poses, i, e):
                    for a in (DESIRED_X, SOLVED_X):
                        fastest = max(fastest, predicted[i, a] ** 2 + predicted[i, a + 1] ** 2)
    if not pair and not wall:
        return 0
    if not world.ideal_drive:
        return most
    return max(math.ceil(math.sqrt(fastest) / MAX_CLOSING * world.tick - 1e-6), WALL_SUBSTEPS if wall else 1)


@compiled(forceinline=True, _nrt=False)
def beyond_end(world: WorldArrays, poses: FloatArray, i: int, e: int) -> bool:
    """Whether a robot's centre lies past an end of a wall, so that it could only touch that end."""
    walls = world.walls
    along = (poses[i, 0] - walls[e, p.START_X]) * walls[e, p.ALONG_X] + (poses[i, 1] - walls[e, p.START_Y]) * walls[e, p.ALONG_Y]
    return bool(along < 0.0 or along > walls[e, p.LENGTH])


@compiled(forceinline=True, _nrt=False)
def collision_bias(duration: float, solver_step: float) -> float:
    """Return Chipmunk's collision bias, the share of an overlap that it would leave after a second, for a substep of ``duration`` s.

    It pushes bodies apart with the velocity that takes 1 - bias^solver_step of the overlap away in ``solver_step`` s, but they move for
    ``duration``.
    """
    pushed = (1.0 - 0.5 ** (duration / OVERLAP_HALF_LIFE)) * solver_step / duration
    return float(max(1.0 - pushed, 0.0) ** (1.0 / solver_step))

"""Robots that touch each other and the walls.

The law: contact changes the velocities that the wheels want as little as possible, measured by mass, so that nothing penetrates and
friction stays in Coulomb's cone. Here: at each millisecond, impulses at each contact in turn until they settle.
"""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import NDArray

from docs.studies.calibration.generator.wheels import Effects

Array = NDArray[np.float64]

RADIUS = 0.06
"""Radius of the bump shield, m (hero_plus world)."""
ROBOT_FRICTION = 0.3
"""Coulomb coefficient between robots (hero_plus world)."""
WALL_FRICTION = 0.4
"""Coulomb coefficient between a robot and a wall (hero_plus world)."""
INERTIA_RATIO = 0.5
"""Moment of inertia over m R^2: a uniform disc."""
SWEEPS = 60
"""Most rounds over the contacts in a step; they end when no velocity changes by more than 1e-9 m/s."""


def resolve(
    x: Array, y: Array, vx: Array, vy: Array, omega: Array, arena: tuple[float, float, float, float], effects: Effects, step: float
) -> tuple[Array, Array, Array]:
    """Velocities after contact.

    Args:
        x: Positions along x, m, (B, N).
        y: Positions along y, m, (B, N).
        vx: Wanted velocity along x, m/s, (B, N).
        vy: Wanted velocity along y, m/s, (B, N).
        omega: Wanted turn rate, rad/s, (B, N).
        arena: x0, y0, x1, y1 of the walls, m.
        effects: robot_friction, wall_friction and collision_radius act here.
        step: Time step, s.

    Returns:
        vx, vy and omega, each (B, N).
    """
    vx, vy, omega = vx.copy(), vy.copy(), omega.copy()
    radius = effects.get("collision_radius", {}).get("radius", RADIUS)
    robots = effects.get("robot_friction", {}).get("coefficient", ROBOT_FRICTION)
    walls = effects.get("wall_friction", {}).get("coefficient", WALL_FRICTION)
    _settle(x, y, vx, vy, omega, np.array(arena), radius, robots, walls, step)
    return vx, vy, omega


@numba.njit(cache=True)  # type: ignore[untyped-decorator, unused-ignore] # a loop over contacts, too slow interpreted
def _settle(x, y, vx, vy, omega, arena, radius, robot_friction, wall_friction, step):  # type: ignore[no-untyped-def]
    runs, robots = x.shape
    most = robots * (robots - 1) // 2 + 4 * robots
    first, second = np.empty(most, np.int64), np.empty(most, np.int64)
    nx, ny, gap, push, rub = np.empty(most), np.empty(most), np.empty(most), np.empty(most), np.empty(most)
    spin = radius / (INERTIA_RATIO * radius * radius)
    for b in range(runs):
        count = 0
        for j in range(robots):
            for i in range(j):
                dx, dy = x[b, j] - x[b, i], y[b, j] - y[b, i]
                distance = math.sqrt(dx * dx + dy * dy)
                if distance - 2 * radius < 0.002:
                    first[count], second[count] = i, j
                    nx[count], ny[count], gap[count] = dx / distance, dy / distance, distance - 2 * radius
                    count += 1
            # a wall is an unmovable first party
            for side in range(4):
                room = (x[b, j] - arena[0], y[b, j] - arena[1], arena[2] - x[b, j], arena[3] - y[b, j])[side] - radius
                if room < 0.002:
                    first[count], second[count] = -1, j
                    nx[count], ny[count] = (1.0, 0.0, -1.0, 0.0)[side], (0.0, 1.0, 0.0, -1.0)[side]
                    gap[count] = room
                    count += 1
        push[:count] = 0.0
        rub[:count] = 0.0
        for _ in range(SWEEPS if count else 0):
            change = 0.0
            for c in range(count):
                i, j = first[c], second[c]
                tx, ty = -ny[c], nx[c]
                normal = vx[b, j] * nx[c] + vy[b, j] * ny[c]
                parties, friction = 1.0, wall_friction
                if i >= 0:
                    normal -= vx[b, i] * nx[c] + vy[b, i] * ny[c]
                    parties, friction = 2.0, robot_friction
                # a gap may close within the step and no more
                impulse = max(0.0, push[c] - (normal + gap[c] / step) / parties) - push[c]
                push[c] += impulse
                vx[b, j] += impulse * nx[c]
                vy[b, j] += impulse * ny[c]
                if i >= 0:
                    vx[b, i] -= impulse * nx[c]
                    vy[b, i] -= impulse * ny[c]
                change = max(change, abs(impulse))
                # the touching points slide with the robots and with their spins
                slide = vx[b, j] * tx + vy[b, j] * ty - omega[b, j] * radius
                if i >= 0:
                    slide -= vx[b, i] * tx + vy[b, i] * ty + omega[b, i] * radius
                bound = friction * push[c]
                impulse = min(bound, max(-bound, rub[c] - slide / (parties * (1 + spin * radius)))) - rub[c]
                rub[c] += impulse
                vx[b, j] += impulse * tx
                vy[b, j] += impulse * ty
                omega[b, j] -= impulse * spin
                if i >= 0:
                    vx[b, i] -= impulse * tx
                    vy[b, i] -= impulse * ty
                    omega[b, i] -= impulse * spin
                change = max(change, abs(impulse))
            if change < 1e-9:
                break

"""When and where robots will touch, judging by what contact made of their velocities in the substep before."""

from __future__ import annotations

import math

from swarm_envs.compiled import compiled
from swarm_envs.simulation import parameters as p
from swarm_envs.simulation.parameters import FloatArray, WorldArrays
from swarm_envs.simulation.state import StateArrays
from swarm_envs.simulation.trigonometry import cos_sin

CONTACT_MARGIN = 1e-4
"""What a robot's disc is larger in m for Chipmunk: robots that slide round each other still touch in the middle of a substep, where the
chord of their way opens a gap of up to 0.1 mm. Touches are predicted at half of this depth, so that no contact begins on its edge."""
UNSOLVED_APPROACH = 0.005
"""Robots that touch and approach each other at more m/s than this, as contact made them move last, were not solved together yet."""
STEADY_COMMAND = 1e-3
"""A robot that sets out at a speed or turn rate within this many m/s or rad/s of the tick before still does the same."""

# Columns of a robot's predicted motion: as desired and as contact solved it, m/s; whether contact blocked it; by how much contact turned
# it, rad/s; the speed and turn rate that it set out with when contact was last solved.
DESIRED_X, DESIRED_Y, SOLVED_X, SOLVED_Y, BLOCKED, TURN_BY_CONTACT, LAST_SPEED, LAST_TURN = range(8)


@compiled(forceinline=True, _nrt=False)
def commands_changed(world: WorldArrays, state: StateArrays, w: int, predicted: FloatArray) -> bool:
    """Whether any robot sets out otherwise than in the tick before; note how."""
    found = False
    for i in range(predicted.shape[0]):
        for k in range(2):
            now = state.latched_commands[w, i, k] if world.ideal_drive else state.drive_velocity[w, i, k]
            found = found or abs(now - predicted[i, LAST_SPEED + k]) > STEADY_COMMAND
            predicted[i, LAST_SPEED + k] = now
    return found


@compiled(forceinline=True, _nrt=False)
def predict_velocities(world: WorldArrays, state: StateArrays, w: int, predicted: FloatArray) -> None:
    """Write the velocities with which robots set out: the desired ones, and as contact lets those that it blocked."""
    for i in range(predicted.shape[0]):
        c, s = cos_sin(state.poses[w, i, 2])
        speed = state.latched_commands[w, i, 0] if world.ideal_drive else state.drive_velocity[w, i, 0]
        predicted[i, DESIRED_X], predicted[i, DESIRED_Y] = speed * c, speed * s
        if predicted[i, BLOCKED] == 0.0:
            predicted[i, SOLVED_X], predicted[i, SOLVED_Y] = predicted[i, DESIRED_X], predicted[i, DESIRED_Y]


@compiled(forceinline=True, _nrt=False)
def time_of_impact(world: WorldArrays, poses: FloatArray, predicted: FloatArray) -> float:
    """Return the time in s until two robots, or a robot and a wall, that are apart could touch; infinite if none could.

    It is 0 where two touch that contact has not blocked yet: the next substep is the shortest there is and tells how it will.
    Robots drive straight on, each as desired or as contact made it, whichever brings the two together faster.

    Args:
        world: Parameters.
        poses: (R, 3).
        predicted: (R, 8) columns above.
    """
    count = poses.shape[0]
    earliest = math.inf
    for i in range(count):
        for j in range(i):
            dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
            a = (
                DESIRED_X
                if dx * (predicted[i, DESIRED_X] - predicted[i, SOLVED_X]) + dy * (predicted[i, DESIRED_Y] - predicted[i, SOLVED_Y]) > 0.0
                else SOLVED_X
            )
            b = (
                DESIRED_X
                if dx * (predicted[j, DESIRED_X] - predicted[j, SOLVED_X]) + dy * (predicted[j, DESIRED_Y] - predicted[j, SOLVED_Y]) < 0.0
                else SOLVED_X
            )
            vx, vy = predicted[j, b] - predicted[i, a], predicted[j, b + 1] - predicted[i, a + 1]
            touch = world.robots[i, p.RADIUS] + world.robots[j, p.RADIUS] + CONTACT_MARGIN
            outside, approach = dx * dx + dy * dy - touch * touch, dx * vx + dy * vy
            inside = approach * approach - (vx * vx + vy * vy) * outside
            if approach >= 0.0:
                continue
            if outside > 2.0 * CONTACT_MARGIN * touch:
                if inside > 0.0:
                    # the root of a quadratic in the form that nothing cancels or underflows in: solved velocities fade to 1e-160 m/s
                    earliest = min(earliest, outside / (math.sqrt(inside) - approach))
            elif (
                dx * (predicted[j, SOLVED_X] - predicted[i, SOLVED_X]) + dy * (predicted[j, SOLVED_Y] - predicted[i, SOLVED_Y])
                < -UNSOLVED_APPROACH * touch
            ):
                return 0.0
        for e in range(world.walls.shape[0]):
            ux, uy = world.walls[e, p.ALONG_X], world.walls[e, p.ALONG_Y]
            px, py = poses[i, 0] - world.walls[e, p.START_X], poses[i, 1] - world.walls[e, p.START_Y]
            gap = ux * py - uy * px - world.robots[i, p.RADIUS] - 0.5 * CONTACT_MARGIN
            solved = ux * predicted[i, SOLVED_Y] - uy * predicted[i, SOLVED_X]
            opening = min(ux * predicted[i, DESIRED_Y] - uy * predicted[i, DESIRED_X], solved)
            if opening >= 0.0:
                continue
            if gap > 0.5 * CONTACT_MARGIN:
                earliest = min(earliest, gap / -opening)
            elif gap > -world.robots[i, p.RADIUS] and solved < -UNSOLVED_APPROACH:
                along = px * ux + py * uy
                if 0.0 <= along <= world.walls[e, p.LENGTH]:
                    return 0.0
    return earliest


@compiled(forceinline=True, _nrt=False)
def contacts_persist(world: WorldArrays, poses: FloatArray, predicted: FloatArray, ahead: float) -> bool:
    """Whether all that touch will be within :data:`CONTACT_MARGIN` after ``ahead`` s if they go on as contact made them move."""
    for i in range(poses.shape[0]):
        x, y = poses[i, 0] + ahead * predicted[i, SOLVED_X], poses[i, 1] + ahead * predicted[i, SOLVED_Y]
        for j in range(i):
            touch = world.robots[i, p.RADIUS] + world.robots[j, p.RADIUS] + 2.0 * CONTACT_MARGIN
            dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
            if dx * dx + dy * dy > touch * touch:
                continue
            dx, dy = poses[j, 0] + ahead * predicted[j, SOLVED_X] - x, poses[j, 1] + ahead * predicted[j, SOLVED_Y] - y
            if dx * dx + dy * dy > touch * touch:
                return False
        for e in range(world.walls.shape[0]):
            wall, radius = world.walls[e], world.robots[i, p.RADIUS]
            ux, uy = wall[p.ALONG_X], wall[p.ALONG_Y]
            gap = ux * (poses[i, 1] - wall[p.START_Y]) - uy * (poses[i, 0] - wall[p.START_X]) - radius
            if (
                -radius < gap < CONTACT_MARGIN
                and gap + ahead * (ux * predicted[i, SOLVED_Y] - uy * predicted[i, SOLVED_X]) > CONTACT_MARGIN
            ):
                return False
    return True


@compiled(forceinline=True, _nrt=False)
def turn_to_midpoint(desired: FloatArray, predicted: FloatArray, duration: float) -> None:
    """Turn desired velocities as far as contact, judging by the last substep, turns robots until the middle of the next ``duration`` s."""
    for i in range(desired.shape[0]):
        if predicted[i, TURN_BY_CONTACT] != 0.0:
            c, s = cos_sin(0.5 * duration * predicted[i, TURN_BY_CONTACT])
            desired[i, 0], desired[i, 1] = c * desired[i, 0] - s * desired[i, 1], s * desired[i, 0] + c * desired[i, 1]


@compiled(forceinline=True, _nrt=False)
def record_solution(predicted: FloatArray, desired: FloatArray, values: FloatArray) -> None:
    """Note what contact made of the desired velocities."""
    for i in range(predicted.shape[0]):
        vx, vy = values[6 * i + 3], values[6 * i + 4]
        predicted[i, BLOCKED] = vx != desired[i, 0] or vy != desired[i, 1]
        predicted[i, SOLVED_X], predicted[i, SOLVED_Y] = vx, vy
        predicted[i, TURN_BY_CONTACT] = values[6 * i + 5] - desired[i, 2]

"""The time loop: messages, wheels, contact and the sensor, in steps of a millisecond."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from docs.studies.calibration.generator.contact import resolve
from docs.studies.calibration.generator.sensor import read
from docs.studies.calibration.generator.unlisted import Extra
from docs.studies.calibration.generator.wheels import Effects, wanted

Array = NDArray[np.float64]

STEP = 0.001
"""Time step, s."""

TICK = 100
"""Steps between two readings, and between two commands of a controller: 0.1 s."""

START_OF_CONTROL = 500
"""Step of a swarm run at which its controllers start: 0.5 s."""


@dataclass
class Scene:
    """B runs with N robots each, simulated together.

    Attributes:
        start: Poses at rest, (B, N, 3): x in m, y in m, theta in rad.
        duration: Length of the runs, s.
        factors: Each robot's factor on its linear and angular gain, (B, N, 2).
        messages: Open-loop commands (run index, robot index, t in s, v in m/s, omega in rad/s).
        controllers: For each run v0, w0, v1, w1: the command without and with a detection, (B, 4). None for open-loop runs.
        arena: x0, y0, x1, y1 of the walls, m; None for an open floor on which robots do not meet.
    """

    start: Array
    duration: float
    factors: Array
    messages: list[tuple[int, int, float, float, float]] = field(default_factory=list)
    controllers: Array | None = None
    arena: tuple[float, float, float, float] | None = None


@dataclass
class Track:
    """What truly happened.

    Attributes:
        poses: (steps + 1, B, N, 3), each STEP from time zero, headings not wrapped.
        messages: Commands as sent, lost ones too, in the form of `Scene.messages`.
        readings: (t in s, (B, N) detections as the robots received them).
    """

    poses: Array
    messages: list[tuple[int, int, float, float, float]]
    readings: list[tuple[float, NDArray[np.bool_]]]


def _on_time(effects: Effects) -> int:
    return round(effects.get("dead_time", {}).get("delay", 0.0) / STEP)


def _by_step(scene: Scene) -> dict[int, list[tuple[int, int, float, float]]]:
    due: dict[int, list[tuple[int, int, float, float]]] = {}
    for run, robot, t, v, omega in scene.messages:
        due.setdefault(round(t / STEP), []).append((run, robot, v, omega))
    return due


def simulate(scene: Scene, effects: Effects, random: np.random.Generator, extra: Extra | None = None) -> Track:
    """Act a scene out.

    A start from rest is the moment at which the wheels, asked to stand until then, are asked to move. The floor drifts under a robot
    that moves faster than 1 mm/s or 0.01 rad/s.

    Args:
        scene: Robots and what they are told.
        effects: The hidden effects.
        random: Source of lost messages, kicks, missed and false detections.
        extra: An effect that is on no list.

    Returns:
        The true motion, the commands sent and the readings received.
    """
    steps = round(scene.duration / STEP)
    shape = scene.start.shape[:2]
    x, y, theta = (scene.start[..., k].copy() for k in range(3))
    poses = np.empty((steps + 1, *shape, 3))
    poses[0] = scene.start
    acting = np.zeros((2, *shape))
    v, omega, v_goal, omega_goal = (np.zeros(shape) for _ in range(4))
    due, sent, late = _by_step(scene), list(scene.messages), _on_time(effects)
    arriving: dict[int, list[tuple[NDArray[np.intp], NDArray[np.intp], Array, Array]]] = {}
    readings: list[tuple[float, NDArray[np.bool_]]] = []
    loss = effects.get("command_loss", {}).get("probability", 0.0)
    lag = effects.get("motor_lag", {}).get("time_constant", 0.0)
    keep = np.exp(-STEP / lag) if lag > 0 else 0.0
    drift, kick = effects.get("floor_drift"), effects.get("start_kick")
    rows, columns = (index.ravel() for index in np.indices(shape))

    for step in range(steps):
        t = step * STEP
        batches = []
        if step in due:
            batch = due[step]
            batches.append(tuple(np.array(column) for column in zip(*batch, strict=True)))
        if scene.controllers is not None and step >= START_OF_CONTROL and step % TICK == 0:
            seen = read(poses[: step + 1], STEP, effects, random)
            readings.append((t, seen))
            law = scene.controllers[:, None, :]
            told_v, told_omega = np.where(seen, law[..., 2], law[..., 0]), np.where(seen, law[..., 3], law[..., 1])
            batches.append((rows, columns, told_v.ravel(), told_omega.ravel()))
            sent += [(int(b), int(n), t, float(told_v[b, n]), float(told_omega[b, n])) for b, n in zip(rows, columns, strict=True)]
        for run, robot, told_v, told_omega in batches:
            arrives = random.random(len(run)) >= loss
            arriving.setdefault(step + late, []).append((run[arrives], robot[arrives], told_v[arrives], told_omega[arrives]))
        changed = step in arriving
        for run, robot, told_v, told_omega in arriving.pop(step, []):
            acting[0, run, robot], acting[1, run, robot] = told_v, told_omega
        if changed or "gain_drift" in effects:
            stood = (v_goal == 0) & (omega_goal == 0)
            v_goal, omega_goal = wanted(acting[0], acting[1], scene.factors, t + STEP / 2, effects)
            if kick is not None and changed:
                turned = random.normal(kick["mean"], kick["sd"], shape)
                theta = theta + np.where(stood & ((v_goal != 0) | (omega_goal != 0)), turned, 0.0)
        before_v, before_omega = v, omega
        v, omega = v_goal + (v - v_goal) * keep, omega_goal + (omega - omega_goal) * keep
        # within a step of a lagging robot the mean of both ends moves it; without lag the goal holds all through the step
        mean_v, mean_omega = ((before_v + v) / 2, (before_omega + omega) / 2) if lag > 0 else (v, omega)
        if extra is not None:
            mean_v, mean_omega = extra(mean_v, mean_omega, x, y, theta)
        ahead = theta + mean_omega * (STEP / 2)
        vx, vy = mean_v * np.cos(ahead), mean_v * np.sin(ahead)
        if drift is not None:
            moving = (np.abs(mean_v) > 1e-3) | (np.abs(mean_omega) > 1e-2)
            vx, vy = vx + moving * drift["vx"], vy + moving * drift["vy"]
        if scene.arena is not None:
            vx, vy, mean_omega = resolve(x, y, vx, vy, mean_omega, scene.arena, effects, STEP)
        x, y, theta = x + vx * STEP, y + vy * STEP, theta + mean_omega * STEP
        poses[step + 1, ..., 0], poses[step + 1, ..., 1], poses[step + 1, ..., 2] = x, y, theta
    return Track(poses, sent, readings)

"""Rollouts small enough to embed in a page: whole numbers, base64."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
import numpy.typing as npt

from swarm_envs.simulation import Trajectories

ANGLE = 10_000
"""Steps to a radian."""
LENGTH = 32_000
"""Steps to the arena's longer side: 0.05 mm in the paper's arena."""


def pack_rollout(rollout: Trajectories, every: int) -> dict[str, str]:
    """Return one rollout's poses and detections.

    Args:
        rollout: Of a single world.
        every: Ticks between frames.

    Returns:
        ``poses``: int16 (frames, robots, 3), x and y in :data:`LENGTH` steps to the arena's longer side from its lower left corner,
        heading wrapped to half a turn each way in :data:`ANGLE` steps to a radian; ``seen``: uint8 (frames, robots). Both base64.
    """
    left, bottom, side = frame(rollout)
    poses = rollout.poses[0, ::every]
    whole = np.empty(poses.shape, dtype=np.float64)
    whole[..., :2] = (poses[..., :2] - (left, bottom)) / side * LENGTH
    whole[..., 2] = ((poses[..., 2] + np.pi) % (2 * np.pi) - np.pi) * ANGLE
    seen = rollout.detections[0, ::every].astype(np.uint8)
    if seen.ndim == 3:  # several sensors: does any see something?
        seen = seen.max(axis=2)
    return {"poses": to_base64(np.round(whole).astype("<i2")), "seen": to_base64(seen)}


def describe_scene(rollout: Trajectories, every: int) -> dict[str, Any]:
    """Return what all animations share: lengths in units of the arena's longer side, times in s."""
    left, bottom, side = frame(rollout)
    world = rollout.world
    width, height = world.size

    def outline(points: Any) -> list[list[float]]:
        return [[(x - left) / side, (y - bottom) / side] for x, y in points]

    return {
        "robots": world.num_robots,
        "frames": len(rollout.time[::every]),
        "interval": every * world.tick,
        "width": width / side,
        "height": height / side,
        "metre": 1 / side,
        "contact": [robot.body.contact_radius / side for robot in world.robots],
        "body": [robot.body.visible_radius / side for robot in world.robots],
        "sensors": [[[s.bearing, s.half_angle, s.range / side] for s in robot.sensors] for robot in world.robots],
        "arena": outline(world.arena.outline),
        "obstacles": [outline(obstacle.outline) for obstacle in world.arena.obstacles],
        "length": LENGTH,
        "angle": ANGLE,
    }


def frame(rollout: Trajectories) -> tuple[float, float, float]:
    """Return left, bottom and longer side of the arena in m."""
    xs, ys = zip(*rollout.world.arena.outline, strict=True)
    return min(xs), min(ys), max(rollout.world.size)


def to_base64(array: npt.NDArray[Any]) -> str:
    """Return an array's bytes as text."""
    return base64.b64encode(np.ascontiguousarray(array).tobytes()).decode()

"""Which behaviour is it? Rules that name what a swarm does at the end of a run.

The names are the paper's (Fig. "Discovered Behaviors"): aggregation, cyclic pursuit, dispersal, milling, wall following, and random for
everything else. :func:`features` measures a swarm over the last :data:`WINDOW` seconds, each number without unit, scaled with the robots'
radius, their number, the arena and the world's speed limit. :data:`RULES` says what each behaviour requires of them. :func:`scores` says by
how much each rule is kept or broken, and :func:`label` picks the rule kept best.
``docs/guides/behaviours.md`` shows each class and its borders.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import shapely

from swarm_envs import metrics
from swarm_envs.compiled import compiled
from swarm_envs.deprecation import forwarding
from swarm_envs.metrics import PoseTrajectories
from swarm_envs.simulation.segments import polygon_edges, segment_distance
from swarm_envs.worlds.spec import WorldSpec

Array = npt.NDArray[np.float64]

LABELS = ("aggregation", "cyclic pursuit", "dispersal", "milling", "wall following", "random")
"""Every label there is."""
WINDOW = 20.0
"""Length in s of the last part of a run that is judged: a third of the paper's run. Of a run shorter than twice this, its last half."""
SAMPLE = 0.5
"""Time in s from one judged moment to the next; faster jitter is not motion."""
HEXAGONAL_DENSITY = math.pi / math.sqrt(12)
"""Share of the plane that equal discs cover when packed as tightly as they can be."""
HEXAGONAL_DISTANCE = 0.3772
"""Mean distance of a point of the plane to the nearest point of a hexagonal lattice with one point per unit area."""
WORLDS_AT_ONCE = 256
"""Worlds measured at once; no result depends on it."""


@dataclass(frozen=True)
class Features:
    """What the rules look at, each (worlds,) and without unit; means over the window where nothing else is said.

    c is the swarm's centroid, d_i = |p_i - c|, R the mean contact radius, N the number of robots.
    """

    speed: Array
    """Mean speed over the world's limit of linear speed."""
    cluster: Array
    """Share of robots in the largest cluster; two belong together when the gap between their contact discs is at most R."""
    spread: Array
    """Root mean square of d_i over that of N discs of radius R packed tightest: 1 a heap, 1.25 eight in a touching ring."""
    radial_variation: Array
    """Standard deviation of d_i over their mean: 0 on a circle, about 0.4 in a heap."""
    innermost: Array
    """Smallest d_i over their mean: 1 on a circle, near 0 when a robot sits in the middle."""
    opening: Array
    """Largest angle, seen from c, between robots that follow one another, over the full circle: 1 / N in an even ring."""
    turns: Array
    """Turns that a robot makes about c in 20 s, in the sense in which most turn; the second least of all robots (the least below eight)."""
    tangential: Array
    """Mean velocity around c, in the sense in which most turn, over the mean speed: 1 when all motion is revolution."""
    spacing: Array
    """Mean distance to the nearest neighbour over that of N points in a hexagonal lattice that fills the free floor."""
    emptiness: Array
    """Mean distance from a point of the floor to the nearest robot over that in a hexagonal lattice of N points: 1 is even cover."""
    roaming: Array
    """Root mean square distance of a robot from its own mean position, mean over robots, over the spacing of that lattice: small where
    robots have settled."""
    drift: Array
    """Distance between the centroid's first and last place over the mean length of the robots' ways."""
    crashed: Array
    """Share of robots and moments that touch a wall or obstacle and stand still, below a tenth of the speed limit."""
    wall: Array
    """Share of robots and moments within R of the arena's wall."""
    along_wall: Array
    """Mean over robots of the speed at which a robot makes way along the arena's wall within R of it, to and fro cancelling, over the
    world's limit of linear speed."""
    hugging: Array
    """The same way along the wall over the length of all ways: 1 when robots do nothing else."""
    traced: Array
    """Share of the wall's length that some robot passed along within R of it."""


class Condition(NamedTuple):
    """One condition of a rule: a feature lies above (or below) a threshold; ``scale`` is the distance that counts as one."""

    feature: str
    relation: str
    threshold: float
    scale: float


RULES: dict[str, tuple[Condition, ...]] = {
    "aggregation": (
        Condition("cluster", ">", 0.85, 0.15),
        Condition("spread", "<", 1.7, 0.5),
    ),
    "cyclic pursuit": (
        Condition("radial_variation", "<", 0.3, 0.1),
        Condition("innermost", ">", 0.35, 0.2),
        Condition("opening", "<", 0.4, 0.1),
        Condition("turns", ">", 0.1, 0.1),
        Condition("tangential", ">", 0.6, 0.2),
        Condition("drift", "<", 0.4, 0.2),
        Condition("wall", "<", 0.6, 0.2),
    ),
    "milling": (
        Condition("radial_variation", ">", 0.3, 0.1),
        Condition("spread", ">", 1.3, 0.2),
        Condition("turns", ">", 0.3, 0.2),
        Condition("tangential", ">", 0.5, 0.2),
        Condition("drift", "<", 0.3, 0.2),
        Condition("wall", "<", 0.25, 0.2),
    ),
    "dispersal": (
        Condition("spacing", ">", 0.7, 0.2),
        Condition("emptiness", "<", 1.47, 0.2),
        Condition("roaming", "<", 0.2, 0.1),
        Condition("crashed", "<", 0.45, 0.2),
    ),
    "wall following": (
        Condition("wall", ">", 0.65, 0.2),
        Condition("along_wall", ">", 0.22, 0.2),
        Condition("hugging", ">", 0.6, 0.2),
        Condition("traced", ">", 0.55, 0.2),
    ),
}
"""What each behaviour requires; all of its conditions must hold."""


def label(trajectories: PoseTrajectories) -> list[str]:
    """Name the behaviour of each world: the rule that is kept best, ``random`` where none is kept.

    Args:
        trajectories: Poses (worlds, frames, robots, 3) in m, m, rad, time in s, and their world.

    Returns:
        One of :data:`LABELS` per world. Turning, mirroring or renumbering the swarm does not change it.

    Example:
        >>> import swarm_envs
        >>> label(swarm_envs.rollouts("hero_plus", [[0.07, -1.3, 0.06, 1.1], [0, 0, 0, 0]]))
        ['cyclic pursuit', 'random']
    """
    names = tuple(RULES)
    kept = scores(features(trajectories))
    table = np.stack([kept[name] for name in names], axis=1)
    return [names[best] if row[best] > 0 else "random" for row, best in zip(table, table.argmax(axis=1), strict=True)]


def scores(measured: Features) -> dict[str, Array]:
    """Say how far each rule is kept (positive) or broken (negative), (worlds,) per rule: the margin of its worst condition.

    A margin is the distance from the threshold in units of the condition's scale; near zero is a borderline case.

    Example:
        >>> import swarm_envs
        >>> runs = swarm_envs.rollouts("hero_plus", [[0.07, -1.3, 0.06, 1.1]])
        >>> kept = scores(features(runs))
        >>> max(kept, key=lambda name: kept[name][0])
        'cyclic pursuit'
    """
    return {name: np.min([_margin(measured, condition) for condition in rule], axis=0) for name, rule in RULES.items()}


def _margin(measured: Features, condition: Condition) -> Array:
    value: Array = getattr(measured, condition.feature)
    sign = 1.0 if condition.relation == ">" else -1.0
    return np.nan_to_num(sign * (value - condition.threshold) / condition.scale, nan=-1.0, posinf=9.0, neginf=-9.0)


def features(trajectories: PoseTrajectories) -> Features:
    """Measure what the rules look at.

    Raises:
        ValueError: When fewer than three frames are recorded.
    """
    frames, seconds = _judged_frames(np.asarray(trajectories.time))
    poses = trajectories.poses
    parts = [_measure(trajectories.world, poses[k : k + WORLDS_AT_ONCE][:, frames], seconds) for k in range(0, len(poses), WORLDS_AT_ONCE)]
    if not parts:
        return Features(*(np.empty(0) for _ in fields(Features)))
    return Features(**{f.name: np.concatenate([getattr(part, f.name) for part in parts]) for f in fields(Features)})


def _judged_frames(time: Array) -> tuple[npt.NDArray[np.intp], Array]:
    """Choose the judged frames: their indices and their times."""
    if len(time) < 3:
        raise ValueError(f"the trajectories hold {len(time)} frame(s), expected at least 3: a behaviour needs time to show")
    length = min(WINDOW, (time[-1] - time[0]) / 2)
    step = max(1, round(SAMPLE / (time[-1] - time[-2])))
    first = min(int(np.searchsorted(time, time[-1] - length - 1e-9)), len(time) - 2)
    frames = np.arange(len(time) - 1, first - 1, -step)[::-1]
    if len(frames) < 2:
        frames = np.array([first, len(time) - 1])
    return frames, time[frames]


def _measure(world: WorldSpec, poses: Array, time: Array) -> Features:
    robots = poses.shape[2]
    position = np.ascontiguousarray(poses[..., :2])
    radii = metrics.contact_radii(world)
    radius, limit = float(radii.mean()), world.limits.linear_speed
    velocity = np.diff(position, axis=1) / np.diff(time)[:, None, None]
    speed = np.hypot(velocity[..., 0], velocity[..., 1])
    centroid = position.mean(axis=2, keepdims=True)
    arm = position - centroid
    distance = np.hypot(arm[..., 0], arm[..., 1])
    angle = np.arctan2(arm[..., 1], arm[..., 0])

    turned = ((np.diff(angle, axis=1) + np.pi) % (2 * np.pi) - np.pi).sum(axis=1) / (2 * np.pi) * (20.0 / (time[-1] - time[0]))
    sense = np.where(np.median(turned, axis=1) < 0, -1.0, 1.0)
    slowest = np.sort(turned * sense[:, None], axis=1)[:, 1 if robots >= 8 else 0]
    middle = (arm[:, 1:] + arm[:, :-1]) / 2
    around = (middle[..., 0] * velocity[..., 1] - middle[..., 1] * velocity[..., 0]) / np.maximum(
        np.hypot(middle[..., 0], middle[..., 1]), 1e-9
    )

    gap, tangent, arc_length = _wall_coordinates(position, polygon_edges(world.arena.outline), radii)
    near = gap <= radius
    along = (velocity[..., 0] * tangent[:, 1:, :, 0] + velocity[..., 1] * tangent[:, 1:, :, 1]) * near[:, 1:]
    progress = np.abs(along.mean(axis=1)).mean(axis=1)
    travel = np.maximum(speed.mean(axis=(1, 2)), 1e-9)
    touching = metrics.at_wall(world, position)[:, 1:]
    packed = radius * math.sqrt(robots / (2 * HEXAGONAL_DENSITY))
    lattice = _lattice_spacing(world, radius, robots)
    floor = metrics.floor_points(world, 0.1 * math.sqrt(world.size[0] * world.size[1]))
    return Features(
        speed=speed.mean(axis=(1, 2)) / limit,
        cluster=_largest_cluster(position, radii, radius).mean(axis=1) / robots,
        spread=np.sqrt((distance**2).mean(axis=2)).mean(axis=1) / packed,
        radial_variation=(distance.std(axis=2) / np.maximum(distance.mean(axis=2), 1e-9)).mean(axis=1),
        innermost=(distance.min(axis=2) / np.maximum(distance.mean(axis=2), 1e-9)).mean(axis=1),
        opening=_opening(angle).mean(axis=1),
        turns=slowest,
        tangential=around.mean(axis=(1, 2)) * sense / travel,
        spacing=metrics.nearest_distances(position).mean(axis=(1, 2)) / lattice,
        emptiness=_emptiness(position[:, :: max(1, len(time) // 4)], floor) / (HEXAGONAL_DISTANCE * math.sqrt(_area(world) / robots)),
        roaming=np.sqrt(position.var(axis=1).sum(axis=-1)).mean(axis=1) / lattice,
        drift=np.hypot(*np.moveaxis(centroid[:, -1, 0] - centroid[:, 0, 0], -1, 0)) / (travel * (time[-1] - time[0])),
        crashed=(touching & (speed < 0.1 * limit)).mean(axis=(1, 2)),
        wall=near.mean(axis=(1, 2)),
        along_wall=progress / limit,
        hugging=progress / travel,
        traced=_traced(arc_length[:, 1:], near[:, 1:] & (np.abs(along) > 0.1 * limit), world, radius),
    )


def _lattice_spacing(world: WorldSpec, radius: float, robots: int) -> float:
    """Distance of neighbours when N centres fill the floor that they can reach as a hexagonal lattice."""
    reach = _area(world, radius)
    return math.sqrt(2 * max(reach, radius**2) / (math.sqrt(3) * robots))


def _area(world: WorldSpec, margin: float = 0.0) -> float:
    """Area in m^2 of the floor less a margin in m along every wall."""
    return float(shapely.area(metrics.floor_shape(world, margin)))


def _opening(angle: Array) -> Array:
    """Largest gap between neighbouring directions (worlds, frames, robots), over the full circle: (worlds, frames)."""
    ordered = np.sort(angle, axis=2)
    gaps = np.diff(np.concatenate([ordered, ordered[..., :1] + 2 * np.pi], axis=2), axis=2)
    return np.asarray(gaps.max(axis=2) / (2 * np.pi))


def _emptiness(position: Array, floor: Array) -> Array:
    """Mean distance in m from a floor point (points, 2) to the nearest robot, (worlds,)."""
    apart = np.hypot(position[..., None, 0] - floor[:, 0], position[..., None, 1] - floor[:, 1])
    return np.asarray(apart.min(axis=2).mean(axis=(1, 2)))


def _traced(arc_length: Array, follows: npt.NDArray[np.bool_], world: WorldSpec, radius: float) -> Array:
    """Share of the wall's pieces, a contact disc long, along which some robot went: (worlds,)."""
    length = polygon_edges(world.arena.outline)
    total = float(np.hypot(length[:, 2] - length[:, 0], length[:, 3] - length[:, 1]).sum())
    pieces = max(8, math.floor(total / (2 * radius)))
    piece = np.minimum((arc_length / total * pieces).astype(np.intp), pieces - 1)
    passed = np.zeros((len(arc_length), pieces), dtype=np.bool_)
    which = np.nonzero(follows)
    passed[which[0], piece[which]] = True
    return np.asarray(passed.mean(axis=1))


@compiled()
def _largest_cluster(position: Array, radii: Array, gap: float) -> Array:
    """Robots in the largest group in which each is within ``gap`` of another, disc to disc: (worlds, frames)."""
    worlds, frames, robots = position.shape[:3]
    out = np.empty((worlds, frames))
    for world, frame in np.ndindex(worlds, frames):
        at = position[world, frame]
        waiting = np.arange(robots)
        left, largest = robots, 0
        while left > 0:  # grow one cluster from the last robot that waits
            left -= 1
            members = [waiting[left]]
            done = 0
            while done < len(members):
                i, k = members[done], 0
                done += 1
                while k < left:
                    j = waiting[k]
                    if math.hypot(at[i, 0] - at[j, 0], at[i, 1] - at[j, 1]) <= radii[i] + radii[j] + gap:
                        members.append(j)
                        left -= 1
                        waiting[k] = waiting[left]
                    else:
                        k += 1
            largest = max(largest, len(members))
        out[world, frame] = largest
    return out


@compiled()
def _wall_coordinates(position: Array, edges: Array, radii: Array) -> tuple[Array, Array, Array]:
    """Where each robot is with respect to a closed wall.

    Returns:
        (worlds, frames, robots) gap in m between contact disc and wall; (worlds, frames, robots, 2) direction of the nearest edge;
        (worlds, frames, robots) length in m along the wall from its first corner to the nearest point.
    """
    worlds, frames, robots = position.shape[:3]
    gap, arc_length = np.full((worlds, frames, robots), np.inf), np.zeros((worlds, frames, robots))
    tangent = np.zeros((worlds, frames, robots, 2))
    for world, frame, i in np.ndindex(worlds, frames, robots):
        x, y, start = position[world, frame, i, 0], position[world, frame, i, 1], 0.0
        for k in range(edges.shape[0]):
            dx, dy = edges[k, 2] - edges[k, 0], edges[k, 3] - edges[k, 1]
            length = math.hypot(dx, dy)
            distance = segment_distance(x, y, edges[k]) - radii[i]
            if distance < gap[world, frame, i]:
                gap[world, frame, i] = distance
                tangent[world, frame, i, 0], tangent[world, frame, i, 1] = dx / length, dy / length
                along = ((x - edges[k, 0]) * dx + (y - edges[k, 1]) * dy) / length
                arc_length[world, frame, i] = start + min(length, max(0.0, along))
            start += length
    return gap, tangent, arc_length


__getattr__ = forwarding(__name__, {"Demand": "swarm_envs.behaviours.Condition", "Trajectories": "swarm_envs.metrics.PoseTrajectories"})

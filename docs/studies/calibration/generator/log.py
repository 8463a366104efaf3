"""Logs as a lab would measure them, with effects hidden in them that a calibration must name.

A log is a folder: `log.yaml`, `poses.csv` (run, robot, t, x, y, theta at 60 Hz), `commands.csv` (run, robot, t, v, omega) and, where
swarms ran, `detections.csv` (run, robot, t, detected at 10 Hz). Logs with runs in the arena give its walls in `log.yaml` as
``arena: {outline: [[x, y], ...]}`` in m, in the frame of the poses; without the key the robots drove on an open floor.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import yaml
from numpy.typing import NDArray

from docs.studies.calibration.generator.drives import messages, programme
from docs.studies.calibration.generator.motion import Scene, Track, simulate
from docs.studies.calibration.generator.ranges import EFFECTS
from docs.studies.calibration.generator.swarms import ARENA, PUSHERS, pushes, swarms
from docs.studies.calibration.generator.tracker import Noise, observe
from docs.studies.calibration.generator.unlisted import UNLISTED, Extra
from docs.studies.calibration.generator.wheels import Effects

Array = NDArray[np.float64]

FLEET = 8
"""Robots in the lab: robot_1 to robot_8."""
SPREAD_FLEET = 5
"""Robots that take turns in the drives of a log, so that each comes again."""
LANE = 8.0
"""Distance of the starts of robots that drive in one run, m: far more than a drive covers."""


@dataclass
class _Rows:
    poses: list[str]
    commands: list[str]
    detections: list[str]


def robot_gains(effects: Effects, seed: int) -> Array:
    """Each robot's factor on its linear and angular gain, (FLEET, 2); both of mean one and the standard deviation of robot_spread."""
    sd = effects.get("robot_spread", {}).get("sd", 0.0)
    return 1 + sd * np.random.default_rng([seed, 2]).normal(0.0, 1.0, (FLEET, 2))


def generate_log(
    effects: Effects,
    folder: Path,
    *,
    seed: int,
    runs: int | None = None,
    position_noise: float | None = None,
    heading_noise: float | None = None,
    extra: Extra | str | None = None,
    procedures: Sequence[str] | None = None,
) -> Path:
    """Write a log of robots that have exactly the given effects.

    Args:
        effects: Parameters of each hidden effect, as `draw` gives them. Empty: the ideal robot of the hero_plus world.
        folder: Where to write; made if absent.
        seed: Seed of everything that is drawn here.
        runs: Number of runs; 5 to 20 drawn when absent.
        position_noise: Standard deviation along each axis, m; drawn log-uniformly from 0.05 to 2 mm when absent.
        heading_noise: Standard deviation, rad; drawn log-uniformly from 0.3 to 10 mrad when absent.
        extra: An effect that is on no list: a name of `UNLISTED` or a function of its own.
        procedures: Any of "drives", "swarm" and "pushes". When absent, those that show the effects; without effects one is drawn,
            and an unlisted effect shows in drives.

    Returns:
        The folder.
    """
    random, number, drawn, chance = _begin(seed, runs)
    noise = Noise(drawn[0] if position_noise is None else position_noise, drawn[1] if heading_noise is None else heading_noise)
    if procedures is None:
        shown = {EFFECTS[name].procedure for name in effects}
        procedures = sorted(shown) if shown else ["drives" if extra is not None else chance]
    hidden = UNLISTED[extra](random) if isinstance(extra, str) else extra
    factors = robot_gains(effects, seed)
    rows = _Rows([], [], [])
    for index, procedure in enumerate(procedures):
        count = len(range(index, number, len(procedures)))
        if procedure == "drives":
            scene, places = _drives(random, count, factors, alone=extra is not None)
        elif procedure == "swarm":
            robots = int(random.integers(4, 9))
            scene, places = swarms(random, count, robots, factors[:robots]), _grid("swarm", count, robots)
        else:
            scene, places = pushes(random, count, factors[:PUSHERS]), _grid("push", count, PUSHERS)
        _write_down(simulate(scene, effects, random, hidden), places, effects, noise, random, rows)
    return _save(folder, rows, arena=any(procedure != "drives" for procedure in procedures))


def drawn_extra(name: str, seed: int, runs: int | None = None) -> Extra:
    """Return the effect of `UNLISTED` that `generate_log` hides with a name, a seed and a number of runs."""
    return UNLISTED[name](_begin(seed, runs)[0])


def _begin(seed: int, runs: int | None) -> tuple[np.random.Generator, int, Array, str]:
    """The source of all draws, and the first of them: the number of runs unless given, noise in m and rad, a procedure."""
    random = np.random.default_rng([seed, 3])
    number = int(random.integers(5, 21)) if runs is None else runs
    noise = np.exp(random.uniform(np.log([5e-5, 3e-4]), np.log([2e-3, 1e-2])))
    return random, number, noise, ["drives", "swarm", "pushes"][random.integers(3)]


def _grid(kind: str, runs: int, robots: int) -> list[tuple[str, str, int, int]]:
    return [(f"{kind}_{b + 1}", f"robot_{n + 1}", b, n) for b in range(runs) for n in range(robots)]


def _drives(random: np.random.Generator, runs: int, factors: Array, *, alone: bool) -> tuple[Scene, list[tuple[str, str, int, int]]]:
    """Drives on the open floor, one to three robots per run; each is simulated as a scene of its own since they never meet."""
    team = 1 if alone else int(random.integers(1, 4))
    resend = [None, 0.25][random.integers(2)]
    scripts = programme(random, runs * team)
    told = [messages(script, random, resend) for script in scripts]
    start = np.zeros((runs * team, 1, 3))
    start[:, 0, :2] = random.uniform(-0.4, 0.4, (runs * team, 2))
    # toward the middle of the floor, give or take: where a patch or a stripe would be
    start[:, 0, 2] = np.arctan2(-start[:, 0, 1], -start[:, 0, 0]) + random.uniform(-0.6, 0.6, runs * team)
    start[:, 0, 0] += LANE * (np.arange(runs * team) % team)
    robots = np.arange(runs * team) % SPREAD_FLEET
    places = [(f"drive_{k // team + 1}", f"robot_{robots[k] + 1}", k, 0) for k in range(runs * team)]
    duration = max(script[-1][0] for script in told) + 1.5
    sent = [(k, 0, *message) for k, script in enumerate(told) for message in script]
    return Scene(start, float(np.ceil(duration)), factors[robots][:, None], messages=sent), places


def _write_down(
    track: Track, places: list[tuple[str, str, int, int]], effects: Effects, noise: Noise, random: np.random.Generator, rows: _Rows
) -> None:
    name = {(b, n): f"{run},{robot}" for run, robot, b, n in places}
    for run, robot, b, n in places:
        frames = observe(track, b, n, effects, noise, random)
        rows.poses += [f"{run},{robot},{t:.6f},{x:.7f},{y:.7f},{theta:.7f}" for t, x, y, theta in frames.tolist()]
    rows.commands += [f"{name[b, n]},{t:.3f},{v:.9g},{omega:.9g}" for b, n, t, v, omega in sorted(track.messages)]
    for run, robot, b, n in places:
        rows.detections += [f"{run},{robot},{t:.3f},{int(seen[b, n])}" for t, seen in track.readings]


def _save(folder: Path, rows: _Rows, *, arena: bool) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    about: dict[str, object] = {
        "name": folder.name,
        "robot": "HeRo+",
        "units": {"t": "s from the start of the run", "x": "m", "y": "m", "theta": "rad", "v": "m/s", "omega": "rad/s"},
        "source": "made by the tests",
    }
    if arena:
        x0, y0, x1, y1 = ARENA
        about["arena"] = {"outline": [[x0, y0], [x1, y0], [x1, y1], [x0, y1]]}
    (folder / "log.yaml").write_text(yaml.safe_dump(about, sort_keys=False))
    for file, header, lines in (
        ("poses.csv", "run,robot,t,x,y,theta", rows.poses),
        ("commands.csv", "run,robot,t,v,omega", rows.commands),
        ("detections.csv", "run,robot,t,detected", rows.detections),
    ):
        if lines:
            (folder / file).write_text("\n".join([header, *lines]) + "\n")
    return folder

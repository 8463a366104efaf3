"""Table 2 of the paper in simulation: do behaviours found in one world survive in another, which stands for the real robots?

A behaviour is a medoid of a run. It is run again from new starts in the world that it was found in, and from others in the target. An
attempt in the target succeeds

- *by label* when the rules call it what they called the medoid;
- *by metric distance* when it is no farther from the runs at home than they are from one another: its mean distance to the runs at home
  is at most the 95th percentile of each of those runs' mean distance to the others. Distances are Euclidean over the five hand-crafted
  metrics, each over its standard deviation in the run's archive.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.spatial.distance import cdist

from discovery.controllers import FloatArray, gene_limits
from discovery.errors import DiscoveryError
from discovery.evaluation.groups import representation_name
from discovery.progress import bar
from discovery.randomness import whole_seed
from discovery.rollouts.simulator import Simulator
from discovery.saved_run import Run
from swarm_envs.behaviours import label
from swarm_envs.metrics import hand_crafted
from swarm_envs.worlds import WorldSpec, load_world

Flags = npt.NDArray[np.bool_]

PERCENTILE = 0.95
"""Share of the runs at home that pass their own test of distance."""
ATTEMPTS = 3
"""Attempts that a deployment had in the paper; the first starts here."""
OWN_SPEED = ", own speed"
"""Added to a world's name where its faster controllers are not slowed down to the target's limits."""


@dataclass(frozen=True)
class Transferred:
    """One medoid in the target world."""

    world: str
    """Where it was found."""
    seed: int
    """Of the run that found it."""
    number: int
    """Its place among the run's medoids, from 1."""
    controller: FloatArray
    """(4,) as found."""
    label: str
    """Given by rules when it was found."""
    slowed: float
    """Factor on its four numbers that brought it within the target's limits; 1 leaves it as it is."""
    home_labels: list[str]
    """Of the new runs at home."""
    labels: list[str]
    """Of the attempts in the target."""
    home_distances: FloatArray
    """(S,) mean distance of each run at home to the others there."""
    distances: FloatArray
    """(S,) mean distance of each attempt to the runs at home."""

    @property
    def threshold(self) -> float:
        """Largest distance that counts as the same behaviour."""
        return float(np.quantile(self.home_distances, PERCENTILE))

    @property
    def by_label(self) -> Flags:
        """(S,) which attempts have the label."""
        return np.array([name == self.label for name in self.labels], dtype=np.bool_)

    @property
    def by_metrics(self) -> Flags:
        """(S,) which attempts are near."""
        return np.asarray(self.distances <= self.threshold)

    @property
    def at_home(self) -> float:
        """Share of the new runs at home that have the label."""
        return self.home_labels.count(self.label) / len(self.home_labels)


def mark(attempts: Flags) -> str:
    """Return Table 2's mark of the first attempts: ✓ at once, ◐ within three, ✗ not."""
    return "✓" if attempts[0] else "◐" if attempts[1:ATTEMPTS].any() else "✗"


def within(attempts: Flags, tries: int) -> float:
    """Return the probability that some of ``tries`` attempts, drawn from those made, succeeds."""
    failures, count = int((~attempts).sum()), len(attempts)
    return 1.0 - float(np.prod([max(0, failures - k) / (count - k) for k in range(min(tries, count))]))


def mean_distances(runs: FloatArray, home: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how far runs are from those at home.

    Args:
        runs: (S, 5) scaled metrics of the attempts.
        home: (H, 5) of the runs at home, at least two.

    Returns:
        (H,) mean distance of each run at home to the others there, and (S,) of each attempt to those at home.
    """
    return cdist(home, home).sum(axis=1) / (len(home) - 1), cdist(runs, home).mean(axis=1)


def slow_down(controllers: FloatArray, world: WorldSpec) -> FloatArray:
    """Return the factor (k,) that brings each controller (k, 4) within a world's limits.

    It is one for all four numbers: the robots drive the same paths, slower.
    """
    return np.asarray(1.0 / np.maximum((np.abs(controllers) / gene_limits(world)).max(axis=1), 1.0))


def transfer(runs: list[Run], target: str, starts: int, threads: int) -> list[Transferred]:
    """Run the medoids of runs again, at home and in the target world.

    Controllers beyond the target's limits are slowed down to them; those of such a world are also run at their own speed, as if the target
    had no such limits, under the name of the world with :data:`OWN_SPEED`.

    Args:
        runs: Finished runs, of any worlds.
        target: World that stands for the real robots.
        starts: Runs of each medoid at home, and attempts in the target.
        threads: Cores to use.

    Raises:
        DiscoveryError: When the runs differ in what is not their world, or there are too few starts.
    """
    if starts < ATTEMPTS:
        raise DiscoveryError(f"starts: given {starts}, expected at least {ATTEMPTS}, the attempts that a deployment has")
    kinds = {(representation_name(run), run.settings.engine, run.settings.steps) for run in runs}
    if len(kinds) != 1:
        told = "; ".join(sorted(f"{name}, {engine}, {steps} steps" for name, engine, steps in kinds))
        raise DiscoveryError(f"the runs differ in representation, engine or steps ({told}); give those that differ in world and seed alone")
    aim, found = load_world(target), []
    with bar(len(runs), "transfer", "runs") as progress:
        for run in runs:
            home = load_world(run.settings.world)
            factors = slow_down(_controllers(run), aim)
            found += _judge(run, home, aim, home.name, factors, starts, threads)
            if (gene_limits(home) > gene_limits(aim)).any():
                freed = dataclasses.replace(aim, limits=home.limits)
                found += _judge(run, home, freed, home.name + OWN_SPEED, np.ones(len(factors)), starts, threads)
            progress.update(1)
    return found


def _judge(run: Run, home: WorldSpec, target: WorldSpec, name: str, factors: FloatArray, starts: int, threads: int) -> list[Transferred]:
    settings, controllers = run.settings, _controllers(run)
    scale = run.archive.metrics.std(axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)

    def again(world: WorldSpec, genes: FloatArray, purpose: str) -> tuple[list[list[str]], FloatArray]:
        """Return labels and scaled metrics, medoid by medoid."""
        simulator = Simulator(world, settings.engine, settings.steps, threads)
        trajectories = simulator(np.repeat(genes, starts, axis=0), whole_seed(settings.seed, purpose))
        labels = np.array(label(trajectories)).reshape(-1, starts)
        return labels.tolist(), (hand_crafted(trajectories) / scale).reshape(-1, starts, len(scale))

    home_labels, home_metrics = again(home, controllers, "transfer at home")
    labels, metrics = again(target, controllers * factors[:, None], "transfer attempts")
    return [
        Transferred(
            name, settings.seed, k + 1, controllers[k], medoid.label, float(factors[k]), home_labels[k], labels[k],
            *mean_distances(metrics[k], home_metrics[k]),
        )
        for k, medoid in enumerate(run.medoids)
    ]  # fmt: skip


def _controllers(run: Run) -> FloatArray:
    return np.stack([medoid.controller for medoid in run.medoids])

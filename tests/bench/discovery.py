"""Speed of discovery on one core, as a table: ``make bench``.

Figures are medians over repetitions, per second of CPU time of a process that computes on one thread. The search's own time is measured
with embeddings out of the air, up to 100,000 of them; what a whole generation takes adds the measured evaluation to it.
"""

from __future__ import annotations

import resource
import statistics
import time

import numpy as np
import psutil
import torch
from lightly.loss import NTXentLoss
from threadpoolctl import threadpool_limits

from discovery.clustering.medoids import cluster
from discovery.controllers import random_controllers
from discovery.representations.compute import choose_compute
from discovery.representations.encoder import Encoder, make_network
from discovery.representations.simclr import begin, step
from discovery.representations.videos import VideoRepresentation
from discovery.rollouts.labels import encode_labels
from discovery.rollouts.simulator import Simulator
from discovery.search.search import BehaviourSearch, evaluate
from discovery.settings import SimCLRSettings
from swarm_envs.worlds import load_world
from tests.bench.simulation import line, rate
from tests.discovery.tiny_run import tiny

POPULATION = 50
SIZES = (1_000, 10_000, 100_000)
DIMENSION = 512


def encoder() -> Encoder:
    """A ResNet18 as the search uses it."""
    return Encoder(make_network(3, 0), choose_compute("cpu", "auto"))


def view_rate(batch: int = 100) -> float:
    """Augmented pictures per second of SimCLR's training."""
    settings: SimCLRSettings = tiny("representation=simclr", f"representation.batch={batch}", "dataset.videos=100").representation
    compute = choose_compute("cpu", "auto")
    training = begin(settings, 3, 10, 0, compute, None)
    training.network.train()
    videos, views, loss = torch.randint(0, 255, (batch, 3, 64, 64), dtype=torch.uint8), torch.Generator().manual_seed(0), NTXentLoss(0.5)

    def work() -> int:
        step(training, (videos, videos), views, settings, compute, loss)
        return 2 * batch

    return rate(work)


def embedding_rate() -> float:
    """Videos per second through the encoder."""
    embed, videos = encoder(), np.random.default_rng(0).integers(0, 255, (250, 3, 64, 64), dtype=np.uint8)

    def work() -> int:
        return len(embed(videos))

    return rate(work)


def evaluation_rate(engine: str) -> float:
    """Controllers per second: simulated, rendered, embedded, labelled and measured, a population at a time."""
    world = load_world("hero_plus")
    simulator, representation = Simulator(world, engine, 600, 1), VideoRepresentation(encoder(), tiny().dataset)
    controllers = random_controllers(world, POPULATION, np.random.default_rng(0))

    def work() -> int:
        evaluate(simulator, representation, controllers, 0)
        return POPULATION

    return rate(work)


def generation_seconds(sizes: tuple[int, ...] = SIZES, last: int = 20) -> tuple[list[float], BehaviourSearch]:
    """CPU seconds that the search itself takes for a generation when so many are evaluated: median of the last few before."""
    settings = tiny(f"search.population={POPULATION}", f"search.generations={max(sizes) // POPULATION}", "search.neighbours=15").search
    search, rng, taken = BehaviourSearch(settings, load_world("hero_plus"), DIMENSION, 0), np.random.default_rng(0), []
    labels, metrics = encode_labels(["random"] * POPULATION), np.zeros((POPULATION, 5))
    turn = rng.normal(size=(4, DIMENSION))
    for _ in range(settings.generations):
        begun = time.process_time()
        controllers = search.ask()
        asked = time.process_time() - begun
        embeddings = (np.tanh(20 * controllers @ turn) + 0.1 * rng.normal(size=(POPULATION, DIMENSION))).astype(np.float32)
        begun = time.process_time()
        search.tell(0, {"embeddings": embeddings, "labels": labels, "metrics": metrics})
        taken.append(asked + time.process_time() - begun)
    ends = [size // POPULATION for size in sizes]
    return [statistics.median(taken[max(0, end - last) : end]) for end in ends], search


def main() -> None:
    """Print the table."""
    torch.set_num_threads(1)
    with threadpool_limits(1):
        measure()


def measure() -> None:
    """Print the table, line by line."""
    print(f"{'what, on one core':48} {'per CPU second':>14}  asked for")
    line("SimCLR training, batch 100, views", view_rate())
    line("encoder, embeddings", embedding_rate())
    evaluations = {engine: evaluation_rate(engine) for engine in ("chipmunk", "disc")}
    for engine, each in evaluations.items():
        line(f"evaluations, {engine}", each, "42" if engine == "chipmunk" else "")  # 5,000 in 60 s on two cores
    seconds, search = generation_seconds()
    for size, each in zip(SIZES, seconds, strict=True):
        line(f"the search's own part of a generation at {size:,}, s", each, decimals=4)
    whole = [POPULATION / evaluations["chipmunk"] + each for each in seconds]
    line(f"a generation at {SIZES[-1]:,} over one at {SIZES[0]:,}, ratio", whole[-1] / whole[0], "at most 2", 2)
    archive, begun = search.archive(), time.process_time()
    cluster(archive.embeddings, tiny("clustering.medoids=10").clustering, 0)
    line(f"clusters of {SIZES[-1]:,}, CPU s", time.process_time() - begun, decimals=1)
    line("memory with all of them, GB", psutil.Process().memory_info().rss / 1e9, "", 2)
    line("most memory until then, GB", peak_memory(), "at most 4", 2)


def peak_memory() -> float:
    """Greatest memory that this process held, GB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9


if __name__ == "__main__":
    main()

"""The dataset: videos of random controllers, made and saved in chunks so that a stopped run keeps what it has."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from discovery.controllers import FloatArray, random_controllers
from discovery.progress import bar
from discovery.randomness import generator, whole_seed
from discovery.rollouts.filming import film
from discovery.rollouts.labels import decode_labels, encode_labels
from discovery.rollouts.simulator import Simulator
from discovery.runs.run_folder import RunFolder, part_name
from discovery.settings import DatasetSettings
from swarm_envs.behaviours import label
from swarm_envs.metrics import hand_crafted
from swarm_envs.simulation import Trajectories


@dataclass(frozen=True)
class Dataset:
    """Random controllers and what they did."""

    controllers: FloatArray
    """(N, 4) in m/s and rad/s; each ``dataset.starts`` times, side by side."""
    videos: npt.NDArray[np.uint8]
    """(N, frames, size, size), greyscale."""
    metrics: FloatArray
    """(N, 5), the hand-crafted metrics."""
    labels: npt.NDArray[np.str_]
    """(N,) behaviours, given by rules."""


def make_dataset(folder: RunFolder, simulator: Simulator) -> Dataset:
    """Simulate and render what is not in the folder yet, and return the whole dataset."""
    settings, seed = folder.settings.dataset, folder.settings.seed
    parts = [part.tensors for part in folder.parts("dataset")]
    begins = range(0, settings.videos, settings.chunk)
    with bar(settings.videos, "dataset", "videos", min(len(parts) * settings.chunk, settings.videos)) as progress:
        for number in range(len(parts), len(begins)):
            count = min(settings.chunk, settings.videos - begins[number])
            drawn = random_controllers(simulator.world, count // settings.starts, generator(seed, "dataset controllers", number))
            controllers = np.repeat(drawn, settings.starts, axis=0)
            part = _make_part(simulator, controllers, whole_seed(seed, "dataset starts", number), settings)
            folder.write_tensors(part_name("dataset", number), part, {})
            parts.append(part)
            progress.update(count)
    controllers, filmed, metrics, codes = (
        np.concatenate([part[name] for part in parts]) for name in ("controllers", "videos", "metrics", "labels")
    )
    return Dataset(controllers, filmed, metrics, np.array(decode_labels(codes), dtype=np.str_))


def rollouts_again(folder: RunFolder, simulator: Simulator) -> Iterator[Trajectories]:
    """Repeat the rollouts of a finished dataset, part by part."""
    for number, part in enumerate(folder.parts("dataset")):
        yield simulator(part.tensors["controllers"], whole_seed(folder.settings.seed, "dataset starts", number))


def _make_part(simulator: Simulator, controllers: FloatArray, seed: int, settings: DatasetSettings) -> dict[str, npt.NDArray[Any]]:
    trajectories = simulator(controllers, seed)
    return {
        "controllers": controllers,
        "videos": film(trajectories, settings),
        "metrics": hand_crafted(trajectories),
        "labels": encode_labels(label(trajectories)),
    }

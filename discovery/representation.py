"""Representations: from rollouts to embeddings, one interface for all of them.

A new one is a config in ``configs/representation/``, a settings class, a function ``fit_...`` that returns a
:class:`Representation`, and a line in :data:`METHODS`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt
import torch

from discovery.compute import choose_compute
from discovery.dataset import Dataset
from discovery.encoder import Encoder, load_arrays, make_network, state_arrays
from discovery.run_folder import ENCODER, RunFolder
from discovery.simclr import begin, train
from discovery.weights import NoWeightsError, imagenet_weights
from swarm_envs.rendering import videos
from swarm_envs.simulation import Trajectories


class Representation(Protocol):
    """What the search needs."""

    @property
    def dimension(self) -> int:
        """Numbers in an embedding."""

    def embed(self, trajectories: Trajectories) -> npt.NDArray[np.float32]:
        """Embed each rollout: (W, dimension)."""


@dataclass(frozen=True)
class Fitted:
    """A representation and how it came about."""

    representation: Representation
    origin: str
    """What it started from, in words for the report."""
    losses: list[float]
    """Training loss, one a step; empty when nothing was trained."""
    news: bool
    """Whether it was made now, not read from the folder."""


class VideoRepresentation:
    """Embeds the greyscale video of a rollout with an encoder."""

    def __init__(self, encoder: Encoder, frames: int, size: int) -> None:
        self.encoder, self.frames, self.size = encoder, frames, size
        self.dimension = encoder.dimension

    def embed(self, trajectories: Trajectories) -> npt.NDArray[np.float32]:
        """Render and embed each rollout: (W, dimension)."""
        return self.encoder(videos(trajectories, frames=self.frames, size=self.size))


def fit_simclr(folder: RunFolder, dataset: Dataset) -> Fitted:
    """Train SimCLR on the dataset's videos, or read the encoder that the folder holds already."""
    settings, shape = folder.settings.representation, folder.settings.dataset
    compute = choose_compute(settings.device, settings.precision)
    saved = folder.read_tensors(ENCODER)
    if saved is not None:
        network = make_network(shape.frames, 0)
        load_arrays(network, saved.tensors)
        origin, losses = saved.facts["origin"], saved.facts["losses"]
    else:
        origin, start = starting_weights(folder)
        training = begin(settings, shape.frames, len(dataset.videos) // settings.batch, folder.settings.seed, compute, start)
        train(folder, dataset.videos, compute, training, settings)
        network, losses = training.network, training.losses
        facts = {"architecture": "resnet18", "frames": shape.frames, "size": shape.size, "origin": origin, "losses": losses}
        folder.write_tensors(ENCODER, state_arrays(network), facts)
    folder.remove("training/*.safetensors")
    return Fitted(
        VideoRepresentation(Encoder(network, compute, settings.normalise), shape.frames, shape.size), origin, losses, saved is None
    )


def starting_weights(folder: RunFolder) -> tuple[str, dict[str, torch.Tensor] | None]:
    """Return what training starts from, in words and as tensors (None: random weights), and say it.

    The answer is kept in the folder: a run that began offline from random weights goes on so when the network is back.
    """
    wish, name = folder.settings.representation.weights, "training/start.safetensors"
    kept = folder.read_tensors(name)
    if kept is not None and kept.facts["origin"] != "ImageNet":
        return kept.facts["origin"], None
    origin, start = "random weights, as asked", None
    if wish == "imagenet":
        try:
            origin, start = "ImageNet", imagenet_weights()
        except NoWeightsError as reason:
            origin = f"random weights; ImageNet's cannot be had ({reason})"
    print(f"weights    starting from {origin}", flush=True)
    folder.write_tensors(name, {"none": np.zeros(0)}, {"origin": origin})
    return origin, start


METHODS: dict[str, Callable[[RunFolder, Dataset], Fitted]] = {"simclr": fit_simclr}
"""How each ``representation.method`` is fitted."""

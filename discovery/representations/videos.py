"""Representations that look at a rollout's greyscale video through a ResNet18."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt
import torch

from discovery.errors import DiscoveryError
from discovery.representations.compute import Compute, choose_compute
from discovery.representations.encoder import Encoder, load_arrays, make_network, state_arrays
from discovery.representations.imagenet import NoWeightsError, imagenet_weights
from discovery.run_folder import ENCODER, RunFolder
from discovery.tensor_file import TensorFile
from swarm_envs.rendering import videos
from swarm_envs.simulation import Trajectories


class EncoderSettings(Protocol):
    """Settings that every such representation has."""

    weights: str
    normalise: bool
    device: str
    precision: str


class VideoRepresentation:
    """Embeds the greyscale video of a rollout with an encoder."""

    def __init__(self, encoder: Encoder, frames: int, size: int) -> None:
        self.encoder, self.frames, self.size = encoder, frames, size
        self.dimension = encoder.dimension

    def embed(self, trajectories: Trajectories) -> npt.NDArray[np.float32]:
        """Render and embed each rollout: (W, dimension)."""
        return self.encoder(videos(trajectories, frames=self.frames, size=self.size))


def compute_of(settings: EncoderSettings) -> Compute:
    """Return where and how a representation computes."""
    return choose_compute(settings.device, settings.precision)


def look(folder: RunFolder, network: torch.nn.Module, compute: Compute | None = None) -> VideoRepresentation:
    """Return the representation that a network gives to the videos of a run."""
    settings, shape = folder.settings.representation, folder.settings.dataset
    return VideoRepresentation(Encoder(network, compute or compute_of(settings), settings.normalise), shape.frames, shape.size)


def load_videos(folder: RunFolder) -> VideoRepresentation:
    """Return a finished run's representation; one that was made on a GPU is read where there is none, too.

    Raises:
        DiscoveryError: When the folder lacks the encoder, or it is damaged.
    """
    found = saved_network(folder)
    if found is None:
        raise DiscoveryError(f"{folder.path / ENCODER}: there is none")
    settings = folder.settings.representation
    device = "auto" if settings.device == "cuda" else settings.device
    return look(folder, found[0], choose_compute(device, settings.precision))


def saved_network(folder: RunFolder) -> tuple[torch.nn.Module, TensorFile] | None:
    """Return the encoder that the folder holds already, and the facts beside it."""
    saved = folder.read_tensors(ENCODER)
    if saved is None:
        return None
    network = make_network(folder.settings.dataset.frames, 0)
    load_arrays(network, saved.tensors)
    return network, saved


def save_network(folder: RunFolder, network: torch.nn.Module, origin: str, losses: list[float]) -> None:
    """Write the encoder, and forget the checkpoints on the way to it."""
    shape = folder.settings.dataset
    facts = {"architecture": "resnet18", "frames": shape.frames, "size": shape.size, "origin": origin, "losses": losses}
    folder.write_tensors(ENCODER, state_arrays(network), facts)


def starting_weights(folder: RunFolder) -> tuple[str, dict[str, torch.Tensor] | None]:
    """Return what an encoder starts from, in words and as tensors (None: random weights), and say it.

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

"""Representations that look at a rollout's greyscale video through a ResNet18."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import numpy.typing as npt
import torch

from discovery.errors import DiscoveryError
from discovery.filming import film
from discovery.representations.compute import Compute, choose_compute
from discovery.representations.encoder import Encoder, load_arrays, make_network, state_arrays
from discovery.representations.imagenet import NoWeightsError, imagenet_weights
from discovery.representations.whitening import Whitening, fit_whitening
from discovery.run_folder import ENCODER, RunFolder
from discovery.settings import DatasetSettings
from discovery.tensor_file import TensorFile
from swarm_envs.simulation import Trajectories

Videos = npt.NDArray[np.uint8]
"""(N, frames, size, size)"""
WHITENING = "whitening.safetensors"
"""File of the run folder with what brings embeddings to a common scale."""


class EncoderSettings(Protocol):
    """Settings that every such representation has."""

    weights: str
    normalise: bool
    symmetries: int
    whiten: str
    whiten_variance: float
    device: str
    precision: str


class VideoRepresentation:
    """Embeds the greyscale video of a rollout with an encoder."""

    def __init__(self, encoder: Encoder, shape: DatasetSettings) -> None:
        self.encoder, self.shape = encoder, shape
        self.dimension = encoder.dimension

    def embed(self, trajectories: Trajectories) -> npt.NDArray[np.float32]:
        """Render and embed each rollout: (W, dimension)."""
        return self.encoder(film(trajectories, self.shape))


def compute_of(settings: EncoderSettings) -> Compute:
    """Return where and how a representation computes."""
    return choose_compute(settings.device, settings.precision)


def fit_look(folder: RunFolder, network: torch.nn.Module, videos: Videos) -> VideoRepresentation:
    """Return the representation that a network gives to the videos of a run, whitened over the dataset's when the settings ask for it."""
    settings: EncoderSettings = folder.settings.representation
    compute, whitening = compute_of(settings), None
    if settings.whiten != "none":
        folder.forget_damaged(WHITENING)
        whitening = saved_whitening(folder)
        if whitening is None:
            whitening = fit_whitening(_look(folder, network, compute)(videos, progress=True), settings.whiten, settings.whiten_variance)
            folder.write_tensors(WHITENING, {"mean": whitening.mean, "directions": whitening.directions}, {"method": settings.whiten})
    return VideoRepresentation(_look(folder, network, compute, whitening, settings.normalise), folder.settings.dataset)


def load_videos(folder: RunFolder) -> VideoRepresentation:
    """Return a finished run's representation; one that was made on a GPU is read where there is none, too.

    Raises:
        DiscoveryError: When the folder lacks the encoder or what whitens its embeddings, or they are damaged.
    """
    found = saved_network(folder)
    if found is None:
        raise DiscoveryError(f"{folder.path / ENCODER}: there is none")
    settings = folder.settings.representation
    compute = choose_compute("auto" if settings.device == "cuda" else settings.device, settings.precision)
    whitening = saved_whitening(folder)
    if whitening is None and settings.whiten != "none":
        raise DiscoveryError(f"{folder.path / WHITENING}: there is none, though the run whitened its embeddings")
    return VideoRepresentation(_look(folder, found[0], compute, whitening, settings.normalise), folder.settings.dataset)


def saved_whitening(folder: RunFolder) -> Whitening | None:
    """Return the whitening that the folder holds already."""
    saved = folder.read_tensors(WHITENING)
    return None if saved is None else Whitening(saved.tensors["mean"], saved.tensors["directions"])


def _look(
    folder: RunFolder, network: torch.nn.Module, compute: Compute, whitening: Whitening | None = None, normalise: bool = False
) -> Encoder:
    return Encoder(network, compute, normalise, folder.settings.representation.symmetries, whitening)


def saved_network(folder: RunFolder) -> tuple[torch.nn.Module, TensorFile] | None:
    """Return the encoder that the folder holds already, and the facts beside it."""
    saved = folder.read_tensors(ENCODER)
    if saved is None:
        return None
    network = make_network(folder.settings.dataset.frames, 0)
    load_arrays(network, saved.tensors)
    return network, saved


def save_network(folder: RunFolder, network: torch.nn.Module, origin: str, losses: list[float]) -> None:
    """Write the encoder, and forget what was made with an earlier one that was refused."""
    shape = folder.settings.dataset
    folder.remove(WHITENING)
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

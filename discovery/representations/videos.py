"""Representations that look at a rollout's greyscale video through a ResNet18."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import torch

from discovery.errors import DiscoveryError
from discovery.files.tensor_file import TensorFile
from discovery.representations.affine import SMALLEST, AffineTransform
from discovery.representations.compute import Compute, choose_compute
from discovery.representations.concatenated_metrics import METRICS, ConcatenatedMetrics, fit_concatenated_metrics
from discovery.representations.encoder import Encoder, load_arrays, make_network, state_arrays
from discovery.representations.imagenet import NoWeightsError, imagenet_weights
from discovery.rollouts.dataset import Dataset
from discovery.rollouts.filming import film
from discovery.runs.run_folder import COVARIANCE, ENCODER, RunFolder
from discovery.settings import DatasetSettings, EncoderSettings
from swarm_envs.metrics import hand_crafted
from swarm_envs.simulation import Trajectories

WHITENING = "whitening.safetensors"
"""File of the run folder with what brings embeddings to a common scale."""
CONCATENATION = "beside.safetensors"
"""File of the run folder with the scales of embeddings and of the metrics concatenated with them."""


class VideoRepresentation:
    """Embeds the greyscale video of a rollout with an encoder, and may concatenate its hand-crafted metrics."""

    def __init__(self, encoder: Encoder, shape: DatasetSettings, concatenated: ConcatenatedMetrics | None = None) -> None:
        self.encoder, self.shape, self.concatenated = encoder, shape, concatenated
        self.dimension = encoder.dimension + (0 if concatenated is None else METRICS)

    def embed(self, trajectories: Trajectories) -> npt.NDArray[np.float32]:
        """Render and embed each rollout: (W, dimension)."""
        seen = self.encoder(film(trajectories, self.shape))
        return seen if self.concatenated is None else self.concatenated(seen, hand_crafted(trajectories))


def compute_of(settings: EncoderSettings) -> Compute:
    """Return where and how a representation computes."""
    return choose_compute(settings.device, settings.precision)


def fit_encoder(folder: RunFolder, network: torch.nn.Module, dataset: Dataset) -> VideoRepresentation:
    """Return the representation that a network gives to the videos of a run, brought to scale over the dataset's as the settings ask."""
    settings: EncoderSettings = folder.settings.representation
    compute, whitening, concatenated = compute_of(settings), None, None
    if settings.whiten != "none":
        folder.forget_damaged(WHITENING)
        whitening = saved_whitening(folder)
        if whitening is None:
            plain = _encoder(folder, network, compute)(dataset.videos, progress=True)
            whitening = fit_whitening(plain, settings.whiten, settings.whiten_variance)
            folder.write_tensors(WHITENING, {"mean": whitening.mean, "directions": whitening.matrix}, {"method": settings.whiten})
    encoder = _encoder(folder, network, compute, whitening, settings.normalise)
    if settings.metrics > 0.0:
        folder.forget_damaged(CONCATENATION)
        concatenated = saved_concatenation(folder)
        if concatenated is None:
            concatenated = fit_concatenated_metrics(
                encoder(dataset.videos, progress=True), dataset.metrics, settings.metrics, settings.metrics_square_root
            )
            metadata = {"weight": settings.metrics, "roots": concatenated.square_root}
            folder.write_tensors(CONCATENATION, {"scales": np.array([concatenated.embedding, concatenated.metrics])}, metadata)
    return VideoRepresentation(encoder, folder.settings.dataset, concatenated)


def load_videos(folder: RunFolder) -> VideoRepresentation:
    """Return a finished run's representation; one that was made on a GPU is read where there is none, too.

    Raises:
        DiscoveryError: When the folder lacks the encoder, what whitens its embeddings or what scales them, or they are damaged.
    """
    found = saved_network(folder)
    if found is None:
        raise DiscoveryError(f"{folder.path / ENCODER}: there is none")
    settings = folder.settings.representation
    compute = choose_compute("auto" if settings.device == "cuda" else settings.device, settings.precision)
    whitening = saved_whitening(folder)
    if whitening is None and settings.whiten != "none":
        raise DiscoveryError(f"{folder.path / WHITENING}: there is none, though the run whitened its embeddings")
    concatenated = saved_concatenation(folder)
    if concatenated is None and settings.metrics > 0.0:
        raise DiscoveryError(f"{folder.path / CONCATENATION}: there is none, though the run concatenated metrics with its embeddings")
    return VideoRepresentation(_encoder(folder, found[0], compute, whitening, settings.normalise), folder.settings.dataset, concatenated)


def fit_whitening(embeddings: npt.NDArray[np.float32], method: str, variance: float) -> AffineTransform:
    """Return what gives embeddings (N, d) mean 0 and standard deviation 1: no direction outweighs the others for being long alone.

    Args:
        embeddings: Of the dataset.
        method: ``standardise`` (each number by itself) or ``pca`` (each principal component, which leaves them uncorrelated).
        variance: Share of the variance that the kept principal components hold.

    Raises:
        DiscoveryError: When all embeddings are the same.
    """
    if not embeddings.astype(np.float64).std(axis=0).max() > 0.0:
        raise DiscoveryError("representation.whiten: every video of the dataset has the same embedding; take whiten=none or other videos")
    if method == "standardise":
        return AffineTransform.standardising(embeddings, SMALLEST).in_single_precision()
    return AffineTransform.whitening(embeddings, variance).in_single_precision()


def saved_whitening(folder: RunFolder) -> AffineTransform | None:
    """Return the whitening that the folder holds already."""
    saved = folder.read_tensors(WHITENING)
    return None if saved is None else AffineTransform(saved.tensors["mean"], saved.tensors["directions"])


def saved_concatenation(folder: RunFolder) -> ConcatenatedMetrics | None:
    """Return the scales that the folder holds already."""
    saved = folder.read_tensors(CONCATENATION)
    if saved is None:
        return None
    embedding, metrics = saved.tensors["scales"].tolist()
    return ConcatenatedMetrics(embedding, metrics, saved.metadata.get("roots", False))


def _encoder(
    folder: RunFolder, network: torch.nn.Module, compute: Compute, whitening: AffineTransform | None = None, normalise: bool = False
) -> Encoder:
    return Encoder(network, compute, normalise, folder.settings.representation.symmetries, whitening)


def saved_network(folder: RunFolder) -> tuple[torch.nn.Module, TensorFile] | None:
    """Return the encoder that the folder holds already, and the metadata beside it."""
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
    folder.remove(CONCATENATION)
    folder.remove(COVARIANCE)
    metadata = {"architecture": "resnet18", "frames": shape.frames, "size": shape.size, "origin": origin, "losses": losses}
    folder.write_tensors(ENCODER, state_arrays(network), metadata)


def starting_weights(folder: RunFolder) -> tuple[str, dict[str, torch.Tensor] | None]:
    """Return what an encoder starts from, in words and as tensors (None: random weights), and say it.

    The answer is kept in the folder: a run that began offline from random weights goes on so when the network is back.
    """
    wanted, name = folder.settings.representation.weights, "training/start.safetensors"
    kept = folder.read_tensors(name)
    if kept is not None and kept.metadata["origin"] != "ImageNet":
        return kept.metadata["origin"], None
    origin, start = "random weights, as asked", None
    if wanted == "imagenet":
        try:
            origin, start = "ImageNet", imagenet_weights()
        except NoWeightsError as reason:
            origin = f"random weights; ImageNet's cannot be had ({reason})"
    print(f"weights    starting from {origin}", flush=True)
    folder.write_tensors(name, {"none": np.zeros(0)}, {"origin": origin})
    return origin, start

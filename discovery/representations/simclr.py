"""SimCLR (Chen et al. 2020): the two views of a pair belong together, all others of the batch apart."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import torch
from lightly.loss import NTXentLoss
from lightly.models.modules import SimCLRProjectionHead
from lightly.utils.lars import LARS
from lightly.utils.scheduler import CosineWarmupScheduler
from torch import Tensor

from discovery.randomness import whole_seed
from discovery.representations.augment import augment, draw_views
from discovery.representations.compute import Compute
from discovery.representations.encoder import EMBEDDING, make_network
from discovery.representations.interface import Fitted
from discovery.representations.pairs import Pairs
from discovery.representations.training import Training, describe, train
from discovery.representations.videos import compute_of, fit_encoder, save_network, saved_network, starting_weights
from discovery.rollouts.dataset import Dataset
from discovery.runs.run_folder import RunFolder
from discovery.settings import SimCLRSettings

PROJECTION = 128
"""Numbers in the space where the loss is applied (paper, Deep Learning)."""
LOSS = "NT-Xent loss (nat)"


def fit_simclr(folder: RunFolder, dataset: Dataset) -> Fitted:
    """Train SimCLR on the dataset's videos, or read the encoder that the folder holds already."""
    settings: SimCLRSettings = folder.settings.representation
    found = saved_network(folder)
    if found is not None:
        network, metadata = found[0], found[1].metadata
        origin, losses, done = metadata["origin"], metadata["losses"], "taken from the run folder"
    else:
        origin, start = starting_weights(folder)
        shape = folder.settings.dataset
        pairs = Pairs(len(dataset.videos), shape.starts, settings.batch)
        training = begin(settings, shape.frames, pairs.steps, folder.settings.seed, compute_of(settings), start)
        train_simclr(folder, dataset.videos, pairs, compute_of(settings), training, settings)
        network, losses = training.network, training.losses
        done = f"SimCLR on {len(dataset.videos)} videos, {len(losses)} steps, {describe(losses)}" if losses else "no steps"
        save_network(folder, network, origin, losses)
    return Fitted(fit_encoder(folder, network, dataset), origin, losses, LOSS, done)


def begin(
    settings: SimCLRSettings, frames: int, steps_per_epoch: int, seed: int, compute: Compute, start: Mapping[str, Tensor] | None
) -> Training:
    """Return a training that has not made a step."""
    network = make_network(frames, whole_seed(seed, "network"), start).to(compute.device)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(whole_seed(seed, "projection head"))
        head = SimCLRProjectionHead(EMBEDDING, EMBEDDING, PROJECTION).to(compute.device)
    parameters = [*network.parameters(), *head.parameters()]
    # As in SimCLR, biases and normalisation neither decay nor have their rate adapted: lightly's LARS adapts none where decay is 0.
    groups = [
        {"params": [p for p in parameters if p.ndim > 1], "weight_decay": settings.weight_decay},
        {"params": [p for p in parameters if p.ndim == 1], "weight_decay": 0.0},
    ]
    optimizer = LARS(groups, lr=settings.learning_rate * settings.batch / 256, momentum=settings.momentum)
    total = settings.epochs * steps_per_epoch
    warmup = min(settings.warmup_epochs * steps_per_epoch, total)
    scheduler = CosineWarmupScheduler(optimizer, warmup_epochs=warmup, max_epochs=total, end_value=0.0)
    return Training(network, head, optimizer, scheduler, [])


def step(
    training: Training,
    videos: tuple[Tensor, Tensor],
    views: torch.Generator,
    settings: SimCLRSettings,
    compute: Compute,
    loss: NTXentLoss,
) -> None:
    """Make one step on a batch: the videos (N, frames, size, size) of uint8 that the first views are made of, and the second."""
    crop = (settings.crop_scale[0], settings.crop_scale[1])
    seen = [augment(compute.picture(of), draw_views(len(of), crop, settings.flip, views)) for of in videos]
    with compute.autocast():
        projections = training.head(training.network(torch.cat(seen).contiguous(memory_format=torch.channels_last)))
    training.descend(loss(*projections.float().chunk(2)))


def train_simclr(
    folder: RunFolder, videos: npt.NDArray[np.uint8], pairs: Pairs, compute: Compute, training: Training, settings: SimCLRSettings
) -> None:
    """Train to the end; go on from the last good checkpoint.

    Args:
        folder: Where checkpoints are.
        videos: (N, frames, size, size).
        pairs: Which of them are paired.
        compute: Where and how to compute.
        training: Fresh, from :func:`begin`; trained when this returns.
        settings: The representation's settings.
    """
    seed, data, loss = folder.settings.seed, torch.from_numpy(videos), NTXentLoss(settings.temperature)

    def one(number: int) -> None:
        rows, others = pairs(seed, number)
        first = data[torch.from_numpy(rows)]
        second = first if pairs.starts == 1 else data[torch.from_numpy(others)]
        views = torch.Generator().manual_seed(whole_seed(seed, "views", number))
        step(training, (first, second), views, settings, compute, loss)

    train(folder, training, one, settings.epochs * pairs.steps, settings.batch * 2, settings.checkpoint_seconds)

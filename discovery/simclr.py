"""SimCLR (Chen et al. 2020): two views of a video belong together, all others of the batch apart."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from lightly.loss import NTXentLoss
from lightly.models.modules import SimCLRProjectionHead
from lightly.utils.lars import LARS
from lightly.utils.scheduler import CosineWarmupScheduler
from torch import Tensor, nn

from discovery.augment import augment, draw_views
from discovery.compute import Compute
from discovery.encoder import EMBEDDING, load_arrays, make_network, state_arrays
from discovery.progress import bar
from discovery.randomness import generator, whole_seed
from discovery.run_folder import RunFolder, notice
from discovery.settings import SimCLRSettings
from discovery.tensor_file import DamagedFileError, TensorFile

PROJECTION = 128
"""Numbers in the space where the loss is applied (paper, Deep Learning)."""


@dataclass
class Training:
    """Everything that training changes."""

    network: nn.Module
    head: nn.Module
    optimizer: LARS
    scheduler: CosineWarmupScheduler
    losses: list[float]
    """One a step; its length is the number of steps done."""


def begin(
    settings: SimCLRSettings, frames: int, steps_per_epoch: int, seed: int, compute: Compute, start: Mapping[str, Tensor] | None
) -> Training:
    """Return a training that has not made a step."""
    network = make_network(frames, whole_seed(seed, "network"), start).to(compute.device)
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(whole_seed(seed, "projection head"))
        head = SimCLRProjectionHead(EMBEDDING, EMBEDDING, PROJECTION).to(compute.device)
    parameters = [*network.parameters(), *head.parameters()]
    # As in SimCLR, biases and normalisation neither decay nor have their rate adapted; lightly's LARS takes zero decay as that wish.
    groups = [
        {"params": [p for p in parameters if p.ndim > 1], "weight_decay": settings.weight_decay},
        {"params": [p for p in parameters if p.ndim == 1], "weight_decay": 0.0},
    ]
    optimizer = LARS(groups, lr=settings.learning_rate * settings.batch / 256, momentum=settings.momentum)
    total = settings.epochs * steps_per_epoch
    warmup = min(settings.warmup_epochs * steps_per_epoch, total)
    scheduler = CosineWarmupScheduler(optimizer, warmup_epochs=warmup, max_epochs=total, end_value=0.0)
    return Training(network, head, optimizer, scheduler, [])


def step(training: Training, videos: Tensor, views: torch.Generator, settings: SimCLRSettings, compute: Compute, loss: NTXentLoss) -> None:
    """Make one step on a batch of videos (N, frames, size, size) of uint8."""
    pictures = compute.picture(videos)
    crop = (settings.crop_scale[0], settings.crop_scale[1])
    pairs = [augment(pictures, draw_views(len(pictures), crop, settings.flip, views)) for _ in range(2)]
    with compute.autocast():
        projections = training.head(training.network(torch.cat(pairs).contiguous(memory_format=torch.channels_last)))
    value = loss(*projections.float().chunk(2))
    training.optimizer.zero_grad()
    value.backward()
    training.optimizer.step()
    training.scheduler.step()
    training.losses.append(value.item())


def train(folder: RunFolder, videos: npt.NDArray[np.uint8], compute: Compute, training: Training, settings: SimCLRSettings) -> None:
    """Train to the end, saving a checkpoint every few seconds; go on from the last good one.

    Args:
        folder: Where checkpoints are.
        videos: (N, frames, size, size).
        compute: Where and how to compute.
        training: Fresh, from :func:`begin`; trained when this returns.
        settings: The representation's settings.
    """
    seed, per_epoch = folder.settings.seed, len(videos) // settings.batch
    total, data, loss = settings.epochs * per_epoch, torch.from_numpy(videos), NTXentLoss(settings.temperature)
    resume(folder, training)
    training.network.train()
    training.head.train()
    saved = time.monotonic()
    with bar(total * settings.batch * 2, "training", "views", len(training.losses) * settings.batch * 2) as progress:
        for number in range(len(training.losses), total):
            epoch, place = divmod(number, per_epoch)
            # The last, incomplete batch is dropped: NT-Xent's value depends on the batch's size.
            order = generator(seed, "epoch", epoch).permutation(len(videos))[place * settings.batch : (place + 1) * settings.batch]
            step(
                training,
                data[torch.from_numpy(order)],
                torch.Generator().manual_seed(whole_seed(seed, "views", number)),
                settings,
                compute,
                loss,
            )
            progress.set_postfix_str(f"epoch {epoch + 1}/{settings.epochs}, loss {training.losses[-1]:.3f}", refresh=False)
            progress.update(settings.batch * 2)
            if time.monotonic() - saved >= settings.checkpoint_seconds or number + 1 == total:
                save(folder, training)
                saved = time.monotonic()


def save(folder: RunFolder, training: Training) -> None:
    """Write a checkpoint; the one before it stays, older ones go."""
    tensors: dict[str, npt.NDArray[Any]] = {f"network.{name}": array for name, array in state_arrays(training.network).items()}
    tensors |= {f"head.{name}": array for name, array in state_arrays(training.head).items()}
    state = training.optimizer.state_dict()
    tensors |= {f"momentum.{index}": held["momentum_buffer"].cpu().numpy() for index, held in state["state"].items()}
    schedule = {
        name: value
        for name, value in training.scheduler.state_dict().items()
        if name in ("last_epoch", "_step_count", "_last_lr", "base_lrs")
    }
    facts = {"losses": training.losses, "groups": state["param_groups"], "schedule": schedule}
    folder.write_tensors(f"training/step-{len(training.losses):07d}.safetensors", tensors, facts)
    for old in sorted((folder.path / "training").glob("step-*.safetensors"))[:-2]:
        old.unlink()


def resume(folder: RunFolder, training: Training) -> None:
    """Load the last good checkpoint, if there is one."""
    for path in sorted((folder.path / "training").glob("step-*.safetensors"), reverse=True):
        try:
            checkpoint = folder.read_tensors(f"training/{path.name}")
        except DamagedFileError as error:
            notice(f"refused {error}; going on from the checkpoint before it")
            path.unlink()
            continue
        if checkpoint is not None:
            _restore(training, checkpoint)
            return


def _restore(training: Training, checkpoint: TensorFile) -> None:
    def part(name: str) -> dict[str, npt.NDArray[Any]]:
        return {key.removeprefix(name): array for key, array in checkpoint.tensors.items() if key.startswith(name)}

    load_arrays(training.network, part("network."))
    load_arrays(training.head, part("head."))
    momentum = {int(index): {"momentum_buffer": torch.from_numpy(array)} for index, array in part("momentum.").items()}
    training.optimizer.load_state_dict({"state": momentum, "param_groups": checkpoint.facts["groups"]})
    training.scheduler.load_state_dict({**checkpoint.facts["schedule"], "lr_lambdas": [None] * len(checkpoint.facts["groups"])})
    training.losses[:] = checkpoint.facts["losses"]


def describe(losses: list[float]) -> str:
    """Say the loss at both ends of training."""
    return f"loss {losses[0]:.2f} to {losses[-1]:.2f}" if losses else "no steps"

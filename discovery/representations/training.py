"""Training of an encoder in steps that can be stopped anywhere and go on to the same bits."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import torch
from torch import nn
from torch.optim import Optimizer
from torch.optim.lr_scheduler import LambdaLR

from discovery.files.tensor_file import DamagedFileError, TensorFile
from discovery.progress import bar
from discovery.representations.encoder import load_arrays, state_arrays
from discovery.representations.memory import keep_freed_memory
from discovery.runs.run_folder import RunFolder, notice


@dataclass
class Training:
    """Everything that training changes."""

    network: nn.Module
    head: nn.Module
    optimizer: Optimizer
    scheduler: LambdaLR
    losses: list[float]
    """One per step; its length is the number of steps done."""

    def rate(self, number: int) -> float:
        """Learning rate of step ``number``, from 0, of the first parameters."""
        return float(self.scheduler.base_lrs[0] * self.scheduler.lr_lambdas[0](number))

    def descend(self, loss: torch.Tensor) -> None:
        """Make the step that lowers a loss."""
        self.optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        self.optimizer.step()
        self.scheduler.step()
        self.losses.append(loss.item())


def train(folder: RunFolder, training: Training, step: Callable[[int], None], total: int, views: int, every: float) -> None:
    """Train to the end, saving a checkpoint every few seconds; go on from the last good one.

    Args:
        folder: Where checkpoints are.
        training: Fresh; trained when this returns.
        step: Makes step ``number``; what it draws depends on the number alone.
        total: Steps of the whole training.
        views: Pictures in a step, for the progress bar.
        every: Longest time in s between checkpoints.
    """
    keep_freed_memory()
    resume(folder, training)
    folder.tracker.begin("training")
    for number, loss in enumerate(training.losses):
        folder.tracker.log("training", number + 1, {"loss": loss, "learning_rate": training.rate(number)})
    training.network.train()
    training.head.train()
    saved = time.monotonic()
    with bar(total * views, "training", "views", len(training.losses) * views) as progress:
        for number in range(len(training.losses), total):
            step(number)
            folder.tracker.log("training", number + 1, {"loss": training.losses[-1], "learning_rate": training.rate(number)})
            progress.set_postfix_str(f"step {number + 1}/{total}, loss {training.losses[-1]:.3f}", refresh=False)
            progress.update(views)
            if time.monotonic() - saved >= every or number + 1 == total:
                folder.tracker.flush()  # first: a trained encoder is not logged again
                save(folder, training)
                saved = time.monotonic()


def save(folder: RunFolder, training: Training) -> None:
    """Write a checkpoint; the one before it stays, older ones go."""
    tensors: dict[str, npt.NDArray[Any]] = {f"network.{name}": array for name, array in state_arrays(training.network).items()}
    tensors |= {f"head.{name}": array for name, array in state_arrays(training.head).items()}
    state = training.optimizer.state_dict()
    tensors |= {f"optimizer.{index}.{name}": value.cpu().numpy() for index, held in state["state"].items() for name, value in held.items()}
    schedule = {
        name: value
        for name, value in training.scheduler.state_dict().items()
        if name in ("last_epoch", "_step_count", "_last_lr", "base_lrs")
    }
    metadata = {"losses": training.losses, "groups": state["param_groups"], "schedule": schedule}
    folder.write_tensors(f"training/step-{len(training.losses):07d}.safetensors", tensors, metadata)
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
    state: dict[int, dict[str, torch.Tensor]] = {}
    for key, array in part("optimizer.").items():
        index, name = key.split(".", 1)
        state.setdefault(int(index), {})[name] = torch.from_numpy(np.array(array))
    training.optimizer.load_state_dict({"state": state, "param_groups": checkpoint.metadata["groups"]})
    training.scheduler.load_state_dict({**checkpoint.metadata["schedule"], "lr_lambdas": [None] * len(checkpoint.metadata["groups"])})
    training.losses[:] = checkpoint.metadata["losses"]


def describe(losses: list[float]) -> str:
    """Say the loss at both ends of training."""
    return f"loss {losses[0]:.2f} to {losses[-1]:.2f}" if losses else "no steps"

"""The encoder: a ResNet18 from videos to 512 numbers."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import numpy.typing as npt
import torch
from torch import nn
from torch.nn import functional
from torchvision.models import resnet18

from discovery.progress import bar
from discovery.representations.compute import Compute
from discovery.representations.small_maps import quicken

EMBEDDING = 512
"""Numbers in an embedding (ResNet18's last layer before its classifier)."""
BATCH = 250
"""Videos embedded at a time."""


class Encoder:
    """Videos to embeddings.

    Args:
        network: A ResNet18 without its classifier, from :func:`make_network`.
        compute: Where and how it is run.
        normalise: Give embeddings length one, so that distances compare directions, as SimCLR's loss does.
    """

    dimension = EMBEDDING

    def __init__(self, network: nn.Module, compute: Compute, normalise: bool = False) -> None:
        self.network = network.to(compute.device).to(memory_format=torch.channels_last).eval()
        self.compute = compute
        self.normalise = normalise

    def __call__(self, videos: npt.NDArray[np.uint8], progress: bool = False) -> npt.NDArray[np.float32]:
        """Embed videos (N, frames, size, size) as (N, 512)."""
        self.network.eval()
        embeddings = []
        with bar(len(videos) if progress else 0, "embedding", "videos") as shown, torch.inference_mode(), self.compute.autocast():
            for start in range(0, len(videos), BATCH):
                batch = torch.from_numpy(np.ascontiguousarray(videos[start : start + BATCH]))
                embedded = self.network(self.compute.picture(batch)).float()
                embeddings.append((functional.normalize(embedded) if self.normalise else embedded).cpu().numpy())
                shown.update(len(batch))
        return np.concatenate(embeddings) if embeddings else np.empty((0, EMBEDDING), dtype=np.float32)


def make_network(frames: int, seed: int, start: Mapping[str, torch.Tensor] | None = None) -> nn.Module:
    """Return a ResNet18 without its classifier, one input channel a frame.

    Args:
        frames: Frames of a video.
        seed: For the random weights.
        start: Weights of a ResNet18 to start from instead; of its first layer only when ``frames`` is 3, as in its pictures.
    """
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network: nn.Module = resnet18(weights=None)
        if frames != 3:
            network.conv1 = nn.Conv2d(frames, 64, kernel_size=7, stride=2, padding=3, bias=False)
    network.fc = nn.Identity()
    if start is not None:
        keep = {name: tensor for name, tensor in start.items() if not name.startswith("fc.") and (frames == 3 or name != "conv1.weight")}
        network.load_state_dict(keep, strict=False)
    quicken(network)
    network.to(memory_format=torch.channels_last)
    return network


def state_arrays(module: nn.Module) -> dict[str, npt.NDArray[np.generic]]:
    """Return a module's parameters and buffers as arrays by name."""
    return {name: tensor.detach().cpu().contiguous().numpy() for name, tensor in module.state_dict().items()}


def load_arrays(module: nn.Module, arrays: Mapping[str, npt.NDArray[np.generic]]) -> None:
    """Put arrays back into a module's parameters and buffers."""
    module.load_state_dict({name: torch.from_numpy(np.array(array)) for name, array in arrays.items()})

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
from discovery.representations.affine import AffineTransform
from discovery.representations.compute import Compute
from discovery.representations.matmul_convolutions import use_matmul_convolutions
from discovery.representations.symmetry import turned_and_mirrored

EMBEDDING = 512
"""Numbers in an embedding (ResNet18's last layer before its classifier)."""
BATCH = 250
"""Videos embedded at a time, those turned and mirrored included."""


class Encoder:
    """Videos to embeddings.

    Args:
        network: A ResNet18 without its classifier, from :func:`make_network`.
        compute: Where and how it is run.
        normalise: Give embeddings length one, so that distances compare directions, as SimCLR's loss does; after all else.
        symmetries: 1, 4 or 8: embed every video so often, turned and mirrored, and take the mean. Videos that are one another's
            mirror images or (of 8) quarter turns have the same embedding.
        whitening: Brings the embeddings to a common scale.
    """

    def __init__(
        self, network: nn.Module, compute: Compute, normalise: bool = False, symmetries: int = 1, whitening: AffineTransform | None = None
    ) -> None:
        self.network = network.to(compute.device).to(memory_format=torch.channels_last).eval()
        self.compute = compute
        self.normalise = normalise
        self.symmetries = symmetries
        self.whitening = whitening

    @property
    def dimension(self) -> int:
        """Numbers in an embedding."""
        return EMBEDDING if self.whitening is None else self.whitening.dimension

    def __call__(self, videos: npt.NDArray[np.uint8], progress: bool = False) -> npt.NDArray[np.float32]:
        """Embed videos (N, frames, size, size) as (N, dimension)."""
        self.network.eval()
        embeddings, together = [], max(1, BATCH // self.symmetries)
        with bar(len(videos) if progress else 0, "embedding", "videos") as shown, torch.inference_mode(), self.compute.autocast():
            for start in range(0, len(videos), together):
                batch = torch.from_numpy(np.ascontiguousarray(videos[start : start + together]))
                embeddings.append(self._embed(batch))
                shown.update(len(batch))
        return np.concatenate(embeddings) if embeddings else np.empty((0, self.dimension), dtype=np.float32)

    def _embed(self, videos: torch.Tensor) -> npt.NDArray[np.float32]:
        ways = turned_and_mirrored(videos, self.symmetries).flatten(0, 1)
        embedded = self.network(self.compute.picture(ways)).float().cpu().view(self.symmetries, len(videos), EMBEDDING)
        found: npt.NDArray[np.float32] = (embedded[0] if self.symmetries == 1 else embedded.mean(dim=0)).numpy()
        if self.whitening is not None:
            found = self.whitening(found)
        return functional.normalize(torch.from_numpy(found)).numpy() if self.normalise else found


def make_network(frames: int, seed: int, start: Mapping[str, torch.Tensor] | None = None) -> nn.Module:
    """Return a ResNet18 without its classifier, one input channel a frame.

    Args:
        frames: Frames of a video.
        seed: For the random weights.
        start: Weights of a ResNet18 to start from instead. Its first layer looks at three colours; for another number of frames every frame
            gets the kernels' mean over colours, three over ``frames`` times as strong so that their sum is as large as before.
    """
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(seed)
        network: nn.Module = resnet18(weights=None)
        if frames != 3:
            network.conv1 = nn.Conv2d(frames, 64, kernel_size=7, stride=2, padding=3, bias=False)
    network.fc = nn.Identity()
    if start is not None:
        keep = {name: tensor for name, tensor in start.items() if not name.startswith("fc.")}
        if frames != 3:
            keep["conv1.weight"] = keep["conv1.weight"].mean(dim=1, keepdim=True).repeat(1, frames, 1, 1) * (3 / frames)
        network.load_state_dict(keep, strict=False)
    use_matmul_convolutions(network)
    network.to(memory_format=torch.channels_last)
    return network


def state_arrays(module: nn.Module) -> dict[str, npt.NDArray[np.generic]]:
    """Return a module's parameters and buffers as arrays by name."""
    return {name: tensor.detach().cpu().contiguous().numpy() for name, tensor in module.state_dict().items()}


def load_arrays(module: nn.Module, arrays: Mapping[str, npt.NDArray[np.generic]]) -> None:
    """Put arrays back into a module's parameters and buffers."""
    module.load_state_dict({name: torch.from_numpy(np.array(array)) for name, array in arrays.items()})

"""Convolutions on maps so small that each place sees every other, as one matrix product.

ResNet18's last stage sees pictures of 64 x 64 as maps of 2 x 2. oneDNN's convolution, made for larger maps, took more than a third of a
training step there and a matrix product takes a seventh of that; `make bench` prints views/s.
"""

from __future__ import annotations

from functools import cache

import torch
from torch import Tensor, nn
from torch.nn import functional

SEEN_WHOLE = 2
"""Largest side, in cells, of a map whose every cell is within a 3 x 3 kernel of every other."""


class MatmulConv2d(nn.Conv2d):
    """A 3 x 3 convolution of stride 1 and padding 1 with the same weights and values, faster on maps of up to 2 x 2 on a processor."""

    def forward(self, maps: Tensor) -> Tensor:
        """Convolve maps (N, channels, height, width)."""
        count, channels, height, width = maps.shape
        if max(height, width) > SEEN_WHOLE or maps.device.type != "cpu":
            return super().forward(maps)
        cells = height * width
        taps = self.weight.permute(2, 3, 0, 1).reshape(9, self.out_channels, channels).unbind()
        # Stacked rather than indexed: the gradient of an index with repeats is summed in an order that varies from run to run.
        rows = [torch.stack([taps[tap] for tap in row], dim=1) for row in _taps(height, width)]
        matrix = torch.stack(rows).view(cells * self.out_channels, cells * channels)
        seen = functional.linear(maps.permute(0, 2, 3, 1).reshape(count, cells * channels), matrix)
        return seen.view(count, height, width, self.out_channels).permute(0, 3, 1, 2)


def use_matmul_convolutions(network: nn.Module) -> None:
    """Make every 3 x 3 convolution of stride 1 and padding 1 without bias in a network a :class:`MatmulConv2d`."""
    for module in network.modules():
        if type(module) is nn.Conv2d and module.bias is None and _shape(module) == _SHAPE:
            module.__class__ = MatmulConv2d


_SHAPE = ((3, 3), (1, 1), (1, 1), (1, 1), 1)


def _shape(convolution: nn.Conv2d) -> tuple[object, ...]:
    return convolution.kernel_size, convolution.stride, convolution.padding, convolution.dilation, convolution.groups


@cache
def _taps(height: int, width: int) -> list[list[int]]:
    """Return, for each place of the result and then each of the map, row by row, the kernel's tap that joins them."""
    places = [(y, x) for y in range(height) for x in range(width)]
    return [[(y - to_y + 1) * 3 + x - to_x + 1 for y, x in places] for to_y, to_x in places]

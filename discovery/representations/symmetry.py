"""Pictures turned and mirrored, so that an embedding can be the same for all of them."""

from __future__ import annotations

import torch
from torch import Tensor


def turned_and_mirrored(pictures: Tensor, symmetries: int) -> Tensor:
    """Return each picture in every way that leaves a rectangle or a square in place.

    The pictures are square, the arena's box stretched to fill them. A rectangular arena stays in place when it is mirrored left and right
    or top and bottom or both, and each is an exact picture of the mirrored rollout. Quarter turns too leave the square in place; they
    stretch robots along the other side, as the training's augmentation does.

    Args:
        pictures: (N, frames, size, size).
        symmetries: 1 (as they are), 4 (of a rectangle) or 8 (of a square).

    Returns:
        (symmetries, N, frames, size, size).
    """
    ways = [pictures]
    if symmetries > 1:
        ways += [pictures.flip(3)]
        ways += [way.flip(2) for way in ways]
    if symmetries > 4:
        ways += [way.transpose(2, 3) for way in ways]
    return torch.stack(ways)

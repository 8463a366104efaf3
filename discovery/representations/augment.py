"""The paper's augmentations, a whole batch at once: random crop, horizontal flip, rotation by a multiple of 90 degrees."""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn import functional


@dataclass(frozen=True)
class Views:
    """What is done to each picture of a batch; drawn apart from doing it, so that both can be tested."""

    side: Tensor
    """(N,) side of the square crop as a share of the picture's."""
    centre: Tensor
    """(N, 2) centre of the crop, x right and y down, each from -1 to 1 across the picture."""
    flip: Tensor
    """(N,) bool: mirror left and right."""
    turns: Tensor
    """(N,) int64: quarter turns, counter-clockwise as seen."""


def draw_views(count: int, crop_scale: tuple[float, float], flip: float, generator: torch.Generator) -> Views:
    """Draw views.

    Args:
        count: How many.
        crop_scale: Smallest and largest area of the crop as a share of the picture's.
        flip: Probability of a flip.
        generator: On the CPU, so that every device sees the same views.
    """
    low, high = crop_scale
    side = torch.sqrt(low + (high - low) * torch.rand(count, generator=generator))
    centre = (2 * torch.rand(count, 2, generator=generator) - 1) * (1 - side)[:, None]
    flips = torch.rand(count, generator=generator) < flip
    return Views(side, centre, flips, torch.randint(4, (count,), generator=generator))


def augment(pictures: Tensor, views: Views) -> Tensor:
    """Crop, then flip, then turn each picture; the result has the pictures' size.

    Args:
        pictures: (N, frames, size, size) float; all frames of a video are treated alike.
        views: N of them.

    Returns:
        (N, frames, size, size).
    """
    # Sampling goes backwards, from a place in the result to one in the picture: undo the turn, undo the flip, then enter the crop.
    cosine = torch.tensor([1.0, 0.0, -1.0, 0.0])[views.turns]
    sine = torch.tensor([0.0, 1.0, 0.0, -1.0])[views.turns]
    mirror = torch.where(views.flip, -1.0, 1.0)
    x_row = torch.stack([mirror * cosine * views.side, -mirror * sine * views.side, views.centre[:, 0]], dim=1)
    y_row = torch.stack([sine * views.side, cosine * views.side, views.centre[:, 1]], dim=1)
    affine = torch.stack([x_row, y_row], dim=1).to(pictures.device)
    grid = functional.affine_grid(affine, list(pictures.shape), align_corners=False)
    return functional.grid_sample(pictures, grid, mode="bilinear", padding_mode="border", align_corners=False)

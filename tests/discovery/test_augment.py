"""The augmentations against a derivation with loops and numpy."""

import numpy as np
import numpy.typing as npt
import pytest
import torch

from discovery.representations.augment import Views, augment, draw_views

Picture = npt.NDArray[np.float64]


def pictures(count: int = 3, frames: int = 3, size: int = 9) -> Picture:
    return np.random.default_rng(5).random((count, frames, size, size))


def views(side: float = 1.0, centre: tuple[float, float] = (0.0, 0.0), flip: bool = False, turns: int = 0, count: int = 3) -> Views:
    return Views(torch.full((count,), side), torch.tensor([centre] * count), torch.full((count,), flip), torch.full((count,), turns))


def apply(given: Picture, chosen: Views) -> Picture:
    return augment(torch.from_numpy(given).float(), chosen).numpy().astype(np.float64)


def crop_by_hand(picture: Picture, side: float, centre: tuple[float, float]) -> Picture:
    """Bilinear samples at the centres of a grid of pixels laid over the crop; outside the picture its edge goes on."""
    size = picture.shape[-1]
    result = np.empty_like(picture)
    middle = [(c + 1) / 2 * size for c in centre]
    for row in range(size):
        for column in range(size):
            x = middle[0] + side * (column + 0.5 - size / 2) - 0.5
            y = middle[1] + side * (row + 0.5 - size / 2) - 0.5
            x, y = min(max(x, 0), size - 1), min(max(y, 0), size - 1)
            left, top = min(int(x), size - 2), min(int(y), size - 2)
            a, b = x - left, y - top
            upper = (1 - a) * picture[..., top, left] + a * picture[..., top, left + 1]
            lower = (1 - a) * picture[..., top + 1, left] + a * picture[..., top + 1, left + 1]
            result[..., row, column] = (1 - b) * upper + b * lower
    return result


def test_the_whole_picture_unturned_is_left_alone() -> None:
    assert np.allclose(apply(pictures(), views()), pictures(), atol=1e-5)


@pytest.mark.parametrize("turns", [1, 2, 3])
def test_a_turn_is_exactly_numpys_quarter_turns(turns: int) -> None:
    assert np.allclose(apply(pictures(), views(turns=turns)), np.rot90(pictures(), turns, axes=(-2, -1)), atol=1e-5)


def test_a_flip_mirrors_left_and_right() -> None:
    assert np.allclose(apply(pictures(), views(flip=True)), pictures()[..., ::-1], atol=1e-5)


@pytest.mark.parametrize(("side", "centre"), [(0.8, (0.2, -0.1)), (0.7746, (-0.2254, 0.2254)), (0.9, (0.0, 0.05))])
def test_a_crop_is_resized_bilinearly(side: float, centre: tuple[float, float]) -> None:
    assert np.allclose(apply(pictures(), views(side, centre)), crop_by_hand(pictures(), side, centre), atol=1e-5)


@pytest.mark.parametrize("turns", range(4))
def test_the_order_is_crop_then_flip_then_turn(turns: int) -> None:
    expected = np.rot90(crop_by_hand(pictures(), 0.8, (0.2, -0.1))[..., ::-1], turns, axes=(-2, -1))
    assert np.allclose(apply(pictures(), views(0.8, (0.2, -0.1), True, turns)), expected, atol=1e-5)


def test_every_picture_of_a_batch_has_its_own_view_and_all_its_frames_the_same() -> None:
    given = pictures(40, frames=1).repeat(3, axis=1)
    result = apply(given, draw_views(40, (0.6, 1.0), 0.5, torch.Generator().manual_seed(0)))
    assert np.allclose(result[:, 0], result[:, 1])
    assert np.allclose(result[:, 0], result[:, 2])
    same = pictures(1).repeat(40, axis=0)
    assert len(np.unique(apply(same, draw_views(40, (0.6, 1.0), 0.5, torch.Generator().manual_seed(0))).round(4), axis=0)) == 40


def test_views_are_drawn_as_the_paper_says() -> None:
    drawn = draw_views(20_000, (0.6, 1.0), 0.5, torch.Generator().manual_seed(1))
    area = drawn.side.numpy() ** 2
    assert area.min() >= 0.6 - 1e-6
    assert area.max() <= 1.0
    assert abs(area.mean() - 0.8) < 0.005
    assert np.all(np.abs(drawn.centre.numpy()) + drawn.side.numpy()[:, None] <= 1 + 1e-6), "a crop leaves the picture"
    assert abs(drawn.flip.float().mean().item() - 0.5) < 0.02
    assert np.allclose(np.bincount(drawn.turns.numpy(), minlength=4) / 20_000, 0.25, atol=0.02)

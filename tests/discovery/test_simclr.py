"""Training: the loss sees the right pairs, the optimizer is the paper's."""

import numpy as np
import numpy.typing as npt
import pytest
import torch
from lightly.loss import NTXentLoss
from torch import nn
from torchvision.models import resnet18

from discovery.representations.augment import augment, draw_views
from discovery.representations.compute import Compute
from discovery.representations.encoder import Encoder, make_network
from discovery.representations.simclr import Training, begin, step
from tests.discovery.tiny_run import tiny

CPU = Compute(torch.device("cpu"), torch.float32)


def nt_xent_by_hand(first: npt.NDArray[np.float64], second: npt.NDArray[np.float64], temperature: float) -> float:
    """The paper's equation 1, averaged over both directions of every pair."""
    z = np.concatenate([first, second])
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    similarity, count = np.exp(z @ z.T / temperature), len(first)
    total = 0.0
    for i in range(2 * count):
        partner = (i + count) % (2 * count)
        total -= np.log(similarity[i, partner] / (similarity[i].sum() - similarity[i, i]))
    return total / (2 * count)


def test_a_step_compares_two_views_of_each_video_with_all_others_of_the_batch() -> None:
    settings = tiny().representation
    videos = torch.randint(0, 256, (6, 3, 16, 16), dtype=torch.uint8, generator=torch.Generator().manual_seed(0))
    head = nn.Linear(3 * 16 * 16, 5)
    network = nn.Flatten()
    optimizer = torch.optim.SGD(head.parameters(), lr=0.0)
    training = Training(network, head, optimizer, torch.optim.lr_scheduler.ConstantLR(optimizer), [])  # type: ignore[arg-type]
    step(training, (videos, videos), torch.Generator().manual_seed(3), settings, CPU, NTXentLoss(settings.temperature))

    generator, pictures = torch.Generator().manual_seed(3), videos.float() / 255
    seen = [augment(pictures, draw_views(6, (0.6, 1.0), 0.5, generator)) for _ in range(2)]
    first, second = (head(view.flatten(1)).detach().double().numpy() for view in seen)
    assert training.losses == [pytest.approx(nt_xent_by_hand(first, second, 0.5), abs=1e-5)]


def test_a_step_can_compare_views_of_two_runs_of_each_controller() -> None:
    settings = tiny().representation
    one, other = torch.randint(0, 256, (2, 6, 3, 16, 16), dtype=torch.uint8, generator=torch.Generator().manual_seed(0))
    head, network = nn.Linear(3 * 16 * 16, 5), nn.Flatten()
    optimizer = torch.optim.SGD(head.parameters(), lr=0.0)
    training = Training(network, head, optimizer, torch.optim.lr_scheduler.ConstantLR(optimizer), [])  # type: ignore[arg-type]
    step(training, (one, other), torch.Generator().manual_seed(3), settings, CPU, NTXentLoss(settings.temperature))

    generator = torch.Generator().manual_seed(3)
    seen = [augment(videos.float() / 255, draw_views(6, (0.6, 1.0), 0.5, generator)) for videos in (one, other)]
    first, second = (head(view.flatten(1)).detach().double().numpy() for view in seen)
    assert training.losses == [pytest.approx(nt_xent_by_hand(first, second, 0.5), abs=1e-5)]


def test_the_loss_falls_below_chance_when_the_views_of_a_video_agree() -> None:
    z = torch.nn.functional.normalize(torch.randn(32, 128, generator=torch.Generator().manual_seed(0)))
    loss = NTXentLoss(0.5)
    assert loss(z, z) < loss(z, z.flip(0))
    assert float(loss(torch.ones(32, 8), torch.ones(32, 8))) == pytest.approx(np.log(63), abs=1e-4)


def test_the_paper_scales_the_rate_with_the_batch_and_spares_biases_from_decay() -> None:
    paper = tiny("experiment=paper").representation
    paper.batch, paper.learning_rate, paper.epochs, paper.warmup_epochs = 1000, 0.3, 100, 10
    training = begin(paper, 3, 6, 0, CPU, None)
    adapted, spared = training.optimizer.param_groups
    assert adapted["initial_lr"] == pytest.approx(1.17, abs=0.002)
    assert adapted["weight_decay"] == 1.5e-7
    assert spared["weight_decay"] == 0.0
    assert all(p.ndim > 1 for p in adapted["params"])
    assert all(p.ndim == 1 for p in spared["params"])
    everything = len(list(training.network.parameters())) + len(list(training.head.parameters()))
    assert len(adapted["params"]) + len(spared["params"]) == everything
    assert training.scheduler.scale_lr(0) == pytest.approx(1 / 60)
    assert training.scheduler.scale_lr(59) == 1.0
    assert training.scheduler.scale_lr(599) == pytest.approx(0.0)


def test_the_encoder_gives_512_numbers_and_the_head_128() -> None:
    training = begin(tiny().representation, 3, 1, 0, CPU, None)
    pictures = torch.rand(2, 3, 64, 64)
    assert training.network(pictures).shape == (2, 512)
    assert training.head(training.network(pictures)).shape == (2, 128)


def test_a_normalised_embedding_has_length_one_and_the_same_direction() -> None:
    videos = np.random.default_rng(0).integers(0, 256, (3, 3, 64, 64)).astype(np.uint8)
    network = make_network(3, 0)
    plain, unit = Encoder(network, CPU)(videos), Encoder(network, CPU, normalise=True)(videos)
    assert np.allclose(unit, plain / np.linalg.norm(plain, axis=1, keepdims=True), atol=1e-6)


@pytest.mark.parametrize("frames", [1, 6])
def test_a_network_of_another_number_of_frames_sees_a_still_grey_video_as_the_one_of_three_does(frames: int) -> None:
    start = resnet18(weights=None).state_dict()
    three, others = make_network(3, 0, start).eval(), make_network(frames, 1, start).eval()
    still = torch.rand(2, 1, 64, 64, generator=torch.Generator().manual_seed(0))
    with torch.inference_mode():
        torch.testing.assert_close(others(still.expand(2, frames, 64, 64)), three(still.expand(2, 3, 64, 64)), rtol=1e-3, atol=1e-4)


def test_weights_depend_on_the_seed_alone() -> None:
    torch.manual_seed(1)
    first = begin(tiny().representation, 3, 1, 7, CPU, None).network.state_dict()
    torch.manual_seed(2)
    second = begin(tiny().representation, 3, 1, 7, CPU, None).network.state_dict()
    other = begin(tiny().representation, 3, 1, 8, CPU, None).network.state_dict()
    assert all(torch.equal(first[name], second[name]) for name in first)
    assert not torch.equal(first["conv1.weight"], other["conv1.weight"])

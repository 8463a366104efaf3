"""The quick convolution on small maps is the convolution."""

import pytest
import torch
from torch import nn

from discovery.representations.encoder import make_network
from discovery.representations.matmul_convolutions import MatmulConv2d, use_matmul_convolutions


@pytest.mark.parametrize("side", [(1, 1), (1, 2), (2, 1), (2, 2), (3, 2), (4, 4)])
def test_values_and_gradients_are_those_of_a_convolution(side: tuple[int, int]) -> None:
    torch.manual_seed(1)
    plain = nn.Conv2d(6, 5, 3, padding=1, bias=False).double()
    quick = nn.Sequential(nn.Conv2d(6, 5, 3, padding=1, bias=False).double())
    quick[0].load_state_dict(plain.state_dict())
    use_matmul_convolutions(quick)
    assert isinstance(quick[0], MatmulConv2d)
    maps = torch.randn(7, 6, *side, dtype=torch.float64)
    results = []
    for module in (plain, quick):
        entered = maps.clone().requires_grad_()
        out = module(entered)
        (out * torch.arange(out.numel()).view_as(out)).sum().backward()
        results.append((out, entered.grad, next(module.parameters()).grad))
    for given, expected in zip(results[1], results[0], strict=True):
        torch.testing.assert_close(given, expected)


def test_only_convolutions_that_it_can_stand_in_for_are_replaced() -> None:
    network = nn.Sequential(
        nn.Conv2d(4, 4, 3, padding=1, stride=2, bias=False),
        nn.Conv2d(4, 4, 3, padding=1),
        nn.Conv2d(4, 4, 3, bias=False),
        nn.Conv2d(4, 4, 1, bias=False),
        nn.Conv2d(4, 4, 3, padding=1, groups=2, bias=False),
        nn.Conv2d(4, 4, 3, padding=2, dilation=2, bias=False),
    )
    use_matmul_convolutions(network)
    assert not any(isinstance(module, MatmulConv2d) for module in network)


def test_the_encoder_has_resnet18s_weights_by_their_names() -> None:
    from torchvision.models import resnet18

    ours, theirs = make_network(3, 0).state_dict(), resnet18(weights=None).state_dict()
    assert {name: value.shape for name, value in ours.items()} == {n: v.shape for n, v in theirs.items() if not n.startswith("fc.")}

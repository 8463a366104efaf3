"""Weights to start from: cached ones are used, damaged ones refused, and no network is said within seconds."""

import hashlib
import socket
import time
from pathlib import Path

import pytest
import torch
from torchvision.models import ResNet18_Weights, resnet18

from discovery.representations import imagenet
from discovery.representations.encoder import make_network
from discovery.representations.imagenet import NoWeightsError, imagenet_weights


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("TORCH_HOME", str(tmp_path))
    return tmp_path / "hub" / "checkpoints" / Path(ResNet18_Weights.IMAGENET1K_V1.url).name


def test_a_network_that_never_answers_is_given_up_within_five_seconds(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert imagenet.CONNECT_SECONDS + 0.5 < 5
    monkeypatch.setattr(imagenet, "CONNECT_SECONDS", 0.1)  # a busy machine adds what it likes to any wait, so the wait itself is short here
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: time.sleep(120))
    start = time.monotonic()
    with pytest.raises(NoWeightsError, match="does not answer"):
        imagenet_weights()
    assert time.monotonic() - start < 60, "it waited for the network"


def test_no_network_is_said_at_once(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown(*_: object, **__: object) -> None:
        raise socket.gaierror(-2, "Name or service not known")

    monkeypatch.setattr(socket, "getaddrinfo", unknown)
    with pytest.raises(NoWeightsError, match="cannot be reached"):
        imagenet_weights()


def test_damaged_cached_weights_are_refused(cache: Path) -> None:
    cache.parent.mkdir(parents=True)
    cache.write_bytes(b"half a file")
    with pytest.raises(NoWeightsError, match="damaged"):
        imagenet_weights()


def test_cached_weights_are_used(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    torch.manual_seed(0)
    state = resnet18(weights=None).state_dict()
    cache.parent.mkdir(parents=True)
    torch.save(state, cache)
    digest = hashlib.sha256(cache.read_bytes()).hexdigest()
    monkeypatch.setattr(imagenet, "_check_hash", lambda path: digest)  # a stand-in cannot have the real file's hash
    network = make_network(3, 5, imagenet_weights())
    assert torch.equal(network.state_dict()["layer1.0.conv1.weight"], state["layer1.0.conv1.weight"])

"""Weights to start from: ImageNet's when they can be had, within seconds."""

from __future__ import annotations

import hashlib
import socket
import sys
import threading
import urllib.request
from pathlib import Path
from urllib.error import HTTPError

import torch
from torchvision.models import ResNet18_Weights

CONNECT_SECONDS = 3.0
"""How long to wait for the server's first answer."""
STALL_SECONDS = 10.0
"""How long a download may stand still."""


class NoWeightsError(Exception):
    """ImageNet weights cannot be had; the message says why in a few words."""


def imagenet_weights() -> dict[str, torch.Tensor]:
    """Return ResNet18's ImageNet weights from torch's cache, or through torch.hub into it.

    Raises:
        NoWeightsError: When they are not cached and the server does not answer, or the file is damaged.
    """
    weights = ResNet18_Weights.IMAGENET1K_V1
    cached = Path(torch.hub.get_dir()) / "checkpoints" / Path(weights.url).name
    if cached.exists():
        _check_hash(cached)
    else:
        _knock(weights.url)
        print(f"weights    downloading ResNet18's ImageNet weights, 45 MB, to {cached}", file=sys.stderr, flush=True)
    before = socket.getdefaulttimeout()
    socket.setdefaulttimeout(STALL_SECONDS)
    try:
        # weights_only refuses anything but tensors; torch.hub downloads beside the place, checks the hash, then moves.
        return dict(weights.get_state_dict(progress=True, check_hash=True, weights_only=True))
    except Exception as error:  # a download fails in many ways; none of them is a reason to stop
        raise NoWeightsError(f"the download failed: {' '.join(str(error).split())[:120]}") from None
    finally:
        socket.setdefaulttimeout(before)


def _check_hash(cached: Path) -> None:
    """Refuse a cached file that is not what its name says; torch checks only what it has just downloaded."""
    expected = cached.stem.rsplit("-", 1)[-1]
    if not hashlib.sha256(cached.read_bytes()).hexdigest().startswith(expected):
        raise NoWeightsError(f"{cached} is damaged, delete it")


def _knock(url: str) -> None:
    """Ask the server for the file's header; give up after a few seconds, whatever hangs (name service, proxy, connection)."""
    outcome: list[Exception | None] = []

    def ask() -> None:
        try:
            urllib.request.urlopen(urllib.request.Request(url, method="HEAD"), timeout=CONNECT_SECONDS).close()
            outcome.append(None)
        except HTTPError as error:
            outcome.append(Exception(f"the server says {error.code}"))
        except Exception as error:
            outcome.append(error)

    # A thread, because looking up a name cannot be given a timeout.
    thread = threading.Thread(target=ask, daemon=True)
    thread.start()
    thread.join(CONNECT_SECONDS + 0.5)
    if not outcome:
        raise NoWeightsError(f"{url.split('/')[2]} does not answer")
    if outcome[0] is not None:
        raise NoWeightsError(f"{url.split('/')[2]} cannot be reached")

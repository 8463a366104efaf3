"""Where and in which numbers torch computes: device, memory format, precision."""

from __future__ import annotations

from dataclasses import dataclass

import torch

from discovery.errors import DiscoveryError


@dataclass(frozen=True)
class Compute:
    """How networks are run."""

    device: torch.device
    dtype: torch.dtype
    """bfloat16 (under autocast; weights stay float32) or float32."""

    def autocast(self) -> torch.autocast:
        """Return the context in which the network is evaluated."""
        return torch.autocast(self.device.type, dtype=torch.bfloat16, enabled=self.dtype == torch.bfloat16)

    def picture(self, videos: torch.Tensor) -> torch.Tensor:
        """Turn videos (N, frames, size, size) of uint8 into floats from 0 to 1, on the device, channels last."""
        return (videos.to(self.device).float() / 255).contiguous(memory_format=torch.channels_last)

    def __str__(self) -> str:
        return f"{self.device.type} {str(self.dtype).removeprefix('torch.')}"


def choose_compute(device: str, precision: str) -> Compute:
    """Choose the device and the precision.

    Args:
        device: auto, cpu or cuda.
        precision: auto, float32 or bfloat16.

    Raises:
        DiscoveryError: When a GPU is asked for and there is none.
    """
    if device == "cuda" and not torch.cuda.is_available():
        raise DiscoveryError("representation.device: given 'cuda', but torch finds no GPU here; take auto or cpu")
    where = "cuda" if device == "cuda" or (device == "auto" and torch.cuda.is_available()) else "cpu"
    if precision == "auto":
        precision = "bfloat16" if _has_bfloat16(where) else "float32"
    return Compute(torch.device(where), torch.bfloat16 if precision == "bfloat16" else torch.float32)


def _has_bfloat16(device: str) -> bool:
    """Whether the processor multiplies bfloat16 natively; torch emulates it on others, slower than float32."""
    if device == "cuda":
        return bool(torch.cuda.is_bf16_supported(including_emulation=False))
    checks = ("_is_avx512_bf16_supported", "_is_amx_tile_supported")
    return any(getattr(torch.cpu, check, lambda: False)() for check in checks)

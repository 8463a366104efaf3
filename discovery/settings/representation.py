"""Settings of representations, one class for each ``representation.method``; what they mean is said in ``configs/representation``."""

from __future__ import annotations

from dataclasses import dataclass

from omegaconf import MISSING

from discovery.settings.fields import choice, number


@dataclass
class HandCraftedSettings:
    """Five metrics instead of a network."""

    method: str = choice("hand_crafted")
    standardise: bool = MISSING
    square_root: bool = False


@dataclass
class EncoderSettings:
    """A ResNet18, and what is made of its 512 numbers, in this order."""

    method: str = MISSING
    weights: str = choice("imagenet", "random")
    symmetries: int = choice(1, 4, 8, neutral=1)
    whiten: str = choice("none", "standardise", "pca", neutral="none")
    whiten_variance: float = number(0.01, 1.0, neutral=0.95)
    normalise: bool = MISSING
    metrics: float = number(0.0, neutral=0.0)
    metrics_square_root: bool = False
    device: str = choice("auto", "cpu", "cuda")
    precision: str = choice("auto", "float32", "bfloat16")


@dataclass
class UntrainedSettings(EncoderSettings):
    """A ResNet18 that is not trained."""

    method: str = choice("untrained")


@dataclass
class TrainedSettings(EncoderSettings):
    """What every training of a ResNet18 on augmented videos has."""

    epochs: int = number(0)
    batch: int = number(1)
    learning_rate: float = number(0.0)
    weight_decay: float = number(0.0)
    crop_scale: list[float] = number(0.01, 1.0)
    flip: float = number(0.0, 1.0)
    checkpoint_seconds: float = number(0.0, 60.0)


@dataclass
class SimCLRSettings(TrainedSettings):
    """Contrastive learning, with the NT-Xent loss."""

    method: str = choice("simclr")
    batch: int = number(2)
    momentum: float = number(0.0, 1.0)
    warmup_epochs: int = number(0)
    temperature: float = number(1e-6)


@dataclass
class TripletSettings(TrainedSettings):
    """Learning from judgements of which of two rollouts is more like a third, with the triplet margin loss."""

    method: str = choice("triplet")
    judgements: str | None = MISSING
    answers: int = number(1)
    error_rate: float = number(0.0, 1.0)
    margin: float = number(0.0)


REPRESENTATIONS: dict[str, type] = {
    "hand_crafted": HandCraftedSettings, "simclr": SimCLRSettings, "triplet": TripletSettings, "untrained": UntrainedSettings,
}  # fmt: skip
"""Settings class of each representation.method."""

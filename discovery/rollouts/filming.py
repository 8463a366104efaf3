"""From rollouts to the videos that a run's dataset settings ask for, and what videos are known by."""

from __future__ import annotations

import hashlib

import numpy as np
import numpy.typing as npt

from discovery.settings import DatasetSettings
from swarm_envs.rendering import trails
from swarm_envs.rendering import videos as render_videos
from swarm_envs.simulation import Trajectories


def film(trajectories: Trajectories, settings: DatasetSettings) -> npt.NDArray[np.uint8]:
    """Draw W rollouts: (W, frames, size, size) greyscale, over the robots' trails when the settings ask for them."""
    filmed = render_videos(trajectories, frames=settings.frames, size=settings.size)
    if settings.trail:
        np.maximum(filmed, trails(trajectories, frames=settings.frames, size=settings.size), out=filmed)
    return filmed


def fingerprint(videos: npt.NDArray[np.uint8]) -> str:
    """Return what a dataset's videos (N, frames, size, size) are known by."""
    return hashlib.sha256(videos.tobytes()).hexdigest()[:16]

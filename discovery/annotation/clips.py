"""Rollouts to show, by row: those of a run's dataset, or of a test set."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from discovery.randomness import whole_seed
from discovery.rollouts.filming import fingerprint
from discovery.rollouts.simulator import Simulator
from discovery.rollouts.test_set import LabelledTestSet
from discovery.runs.run_folder import RunFolder
from swarm_envs.simulation import Trajectories


class Clips(Protocol):
    """What a person is asked about."""

    @property
    def fingerprint(self) -> str:
        """What the answers are about; another set has another."""

    def __len__(self) -> int: ...

    def rollout(self, row: int) -> Trajectories:
        """One rollout."""


@dataclass(frozen=True)
class DatasetClips:
    """The videos that a run learned from, simulated again when they are shown."""

    simulator: Simulator
    seed: int
    chunk: int
    controllers: npt.NDArray[np.float64]
    """(N, 4)"""
    fingerprint: str

    def __len__(self) -> int:
        return len(self.controllers)

    def rollout(self, row: int) -> Trajectories:
        """Return the rollout that the video of a row was made from."""
        part, index = divmod(row, self.chunk)
        return self.simulator.again(self.controllers[row], whole_seed(self.seed, "dataset starts", part), index)


def dataset_clips(folder: RunFolder, simulator: Simulator) -> DatasetClips:
    """Return the clips of a run folder's dataset."""
    parts = [part.tensors for part in folder.parts("dataset")]
    shown = np.concatenate([part["videos"] for part in parts])
    controllers = np.concatenate([part["controllers"] for part in parts])
    return DatasetClips(simulator, folder.settings.seed, folder.settings.dataset.chunk, controllers, fingerprint(shown))


@dataclass(frozen=True)
class LabelledClips:
    """The rollouts of a test set."""

    test: LabelledTestSet

    @property
    def fingerprint(self) -> str:
        """What the answers are about."""
        return self.test.fingerprint

    def __len__(self) -> int:
        return len(self.test.labels)

    def rollout(self, row: int) -> Trajectories:
        """Return the rollout of a row."""
        for part in self.test.parts:
            if row < len(part.poses):
                return part[row : row + 1]
            row -= len(part.poses)
        raise IndexError(row)

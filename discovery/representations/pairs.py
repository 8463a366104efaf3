"""Which two videos of the dataset give the two views of each pair: the same one, or two runs of one controller."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from discovery.randomness import generator

Rows = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Pairs:
    """The pairs of a training, in which no controller comes twice in a batch and no video is a first view twice in an epoch.

    With one start, both views are of one video, as in SimCLR. With more, they are of two runs of a controller: what chance and the
    start did is different in the two, what the controller does is not, so this is what the encoder learns to see.
    """

    videos: int
    """Of the dataset; those of a controller lie side by side."""
    starts: int
    """Videos of each controller."""
    batch: int
    """Pairs per step."""

    @property
    def steps(self) -> int:
        """Steps of an epoch: whole batches of each start's videos. The rest is left out: NT-Xent's value depends on the batch's size."""
        return self.starts * (self.videos // self.starts // self.batch)

    def __call__(self, seed: int, number: int) -> tuple[Rows, Rows]:
        """Return the rows (batch,) of the first views and of the second views of step ``number``, from 0, in a run with ``seed``."""
        epoch, place = divmod(number, self.steps)
        own, place = divmod(place, self.steps // self.starts)
        rng = generator(seed, "epoch", epoch)
        controllers = self.videos // self.starts
        for _ in range(own):
            rng.permutation(controllers)
        chosen = rng.permutation(controllers)[place * self.batch : (place + 1) * self.batch]
        first = chosen * self.starts + own
        if self.starts == 1:
            return first, first
        others = generator(seed, "other start", number).integers(1, self.starts, self.batch)
        return first, chosen * self.starts + (own + others) % self.starts

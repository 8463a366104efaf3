"""The archive as a map: t-SNE of the embeddings, neighbours near each other."""

from __future__ import annotations

import contextlib
import io
import re
from typing import Any

import numpy as np
import numpy.typing as npt
from sklearn.manifold import TSNE

from discovery.progress import bar
from discovery.randomness import generator, whole_seed


def choose_rows(count: int, medoids: npt.NDArray[np.int64], limit: int, seed: int) -> npt.NDArray[np.int64]:
    """Return the archive rows to show, in order: all of them, or a random part that holds every medoid."""
    if count <= limit:
        return np.arange(count)
    others = np.setdiff1d(np.arange(count), medoids)
    drawn = generator(seed, "map").choice(others, max(0, limit - len(medoids)), replace=False)
    return np.sort(np.concatenate([medoids, drawn]))


def lay_out(embeddings: npt.NDArray[Any], iterations: int, seed: int) -> npt.NDArray[np.float64]:
    """Return a place on the map for each embedding, (n, 2), each axis from 0 to 1."""
    if len(embeddings) < 3:
        return np.linspace(0.25, 0.75, len(embeddings))[:, None].repeat(2, axis=1)
    perplexity = min(30.0, (len(embeddings) - 1) / 3)
    tsne = TSNE(init="pca", perplexity=perplexity, max_iter=iterations, random_state=whole_seed(seed, "map") >> 1, verbose=2)
    with bar(iterations, "map", "iterations") as progress, contextlib.redirect_stdout(_Iterations(progress)):
        places = tsne.fit_transform(embeddings)
    low, high = places.min(axis=0), places.max(axis=0)
    return np.asarray((places - low) / np.maximum(high - low, 1e-12), dtype=np.float64)


class _Iterations(io.TextIOBase):
    """Moves a bar by what t-SNE says about itself; it offers no other way to watch it."""

    def __init__(self, progress: Any) -> None:
        self.progress = progress

    def write(self, text: str) -> int:
        for number in re.findall(r"Iteration (\d+)", text):
            self.progress.update(int(number) - self.progress.n)
        return len(text)

"""Which of two rollouts is more like a third? A person's answers, or those of a simulated annotator, always told apart."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from discovery.errors import DiscoveryError
from discovery.files.atomic import write_atomically
from discovery.rollouts.filming import fingerprint

SIMULATED = "simulated annotator"
"""How answers by rule are marked, wherever they are shown."""


@dataclass(frozen=True)
class Judgements:
    """Answers about the videos of one dataset."""

    triples: npt.NDArray[np.int64]
    """(N, 3) rows of the dataset: anchor, the more similar one, the other."""
    annotators: tuple[str, ...]
    """Who gave them."""
    dataset: str
    """Fingerprint of the videos that were judged."""


def simulate_annotator(
    labels: npt.NDArray[np.str_], number: int, error_rate: float, generator: np.random.Generator
) -> npt.NDArray[np.int64]:
    """Judge triples by the rules' labels: of two rollouts the one that has the anchor's label is the more similar.

    Triples in which both or neither have it are passed over, as a person would.

    Args:
        labels: (N,) of the dataset's rollouts.
        number: Answers to give.
        error_rate: Probability of the wrong answer.
        generator: What draws triples and errors.

    Returns:
        (number, 3) rows: anchor, the more similar one, the other.

    Raises:
        DiscoveryError: When all rollouts have the same label.
    """
    if len(set(labels.tolist())) < 2:
        raise DiscoveryError(
            "representation: every rollout of the dataset has the same label, so there is nothing to judge; take more videos"
        )
    judged: list[npt.NDArray[np.int64]] = []
    while sum(map(len, judged)) < number:
        drawn = generator.integers(len(labels), size=(4 * number + 64, 3))
        same = labels[drawn[:, 1:]] == labels[drawn[:, :1]]
        clear = (same[:, 0] != same[:, 1]) & (drawn[:, 0] != drawn[:, 1]) & (drawn[:, 0] != drawn[:, 2])
        drawn, swap = drawn[clear], same[clear, 1]
        swap = swap != (generator.random(len(swap)) < error_rate)
        drawn[swap, 1:] = drawn[swap, :0:-1]
        judged.append(drawn)
    return np.concatenate(judged)[:number]


def write_judgements(path: Path, judgements: Judgements) -> None:
    """Write answers as JSON, the old file whole until the new one is."""
    content = {"dataset": judgements.dataset, "annotators": list(judgements.annotators), "triples": judgements.triples.tolist()}
    write_atomically(path, json.dumps(content) + "\n")


def read_judgements(path: Path, videos: npt.NDArray[np.uint8]) -> Judgements:
    """Read answers about a dataset.

    Raises:
        DiscoveryError: When the file cannot be read, or is about other videos.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        found = Judgements(
            np.array(content["triples"], dtype=np.int64).reshape(-1, 3), tuple(map(str, content["annotators"])), str(content["dataset"])
        )
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DiscoveryError(f"{path}: no judgements can be read ({error}); expected dataset, annotators and triples as JSON") from None
    if found.dataset != fingerprint(videos):
        raise DiscoveryError(f"{path}: judges dataset {found.dataset}, this run's is {fingerprint(videos)}; take its world, seed and sizes")
    if not len(found.triples) or found.triples.min() < 0 or found.triples.max() >= len(videos):
        raise DiscoveryError(f"{path}: names rows outside 0 to {len(videos) - 1}, or none")
    return found

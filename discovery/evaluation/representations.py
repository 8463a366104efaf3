"""Figure 3 of the paper: representation confusion matrices, with nearest neighbours and a linear probe beside them."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from discovery.evaluation import published
from discovery.evaluation.groups import FloatArray, mean_and_error
from discovery.evaluation.probes import probe
from discovery.evaluation.tables import write_csv, write_figure, write_json
from discovery.evaluation.triplets import confusion
from discovery.representations.interface import embed_parts
from discovery.rollouts.test_set import LabelledTestSet
from discovery.saved_run import Run


@dataclass(frozen=True)
class RepresentationScores:
    """One representation on the test set; mean and standard error over its runs."""

    name: str
    runs: int
    confusion: FloatArray
    """(K, K), see :func:`discovery.evaluation.triplets.confusion`."""
    confusion_error: FloatArray
    accuracy: tuple[float, float]
    """Triplet accuracy, each class counted alike."""
    knn: tuple[float, float]
    linear: tuple[float, float]


def score_representations(groups: dict[str, list[Run]], test: LabelledTestSet) -> list[RepresentationScores]:
    """Judge each group of runs on the test set, the most accurate first."""
    classes, scores = test.classes, []
    for name, runs in groups.items():
        matrices, probes = [], []
        for run in runs:
            embeddings = embed_parts(run.representation, test.parts)
            matrices.append(confusion(embeddings, test.labels, classes, run.settings.search.distance))
            probes.append(probe(embeddings, test.labels))
        mean, error = mean_and_error(matrices)
        numbers = {key: mean_and_error([found[key] for found in probes]) for key in ("knn", "linear")}
        accuracy = mean_and_error([np.diag(matrix).mean() for matrix in matrices])
        scores.append(RepresentationScores(name, len(runs), mean, error, _pair(accuracy), _pair(numbers["knn"]), _pair(numbers["linear"])))
    return sorted(scores, key=lambda entry: -entry.accuracy[0])


def write_representations(folder: Path, scores: list[RepresentationScores], test: LabelledTestSet) -> None:
    """Write ``representations.csv``, ``.json``, ``.png`` and ``.svg``."""
    classes = test.classes
    head = ["representation", "runs", "anchor", "what", "share", "standard error"]
    rows = []
    for entry in scores:
        for (i, j), share in np.ndenumerate(entry.confusion):
            what = "right" if i == j else f"{classes[j]} is nearer"
            rows.append([entry.name, entry.runs, classes[i], what, share, entry.confusion_error[i, j]])
    write_csv(folder / "representations.csv", head, rows, test.given_by)
    write_json(
        folder / "representations.json",
        {
            "labels_given_by": test.given_by,
            "test_set": dict(Counter(test.labels.tolist())),
            "classes": classes,
            "gain_over_hand_crafted": gains(scores, classes),
            "paper_gain_of_simclr_over_hand_crafted": published.GAIN,
            "representations": [
                {
                    "name": entry.name, "runs": entry.runs, "confusion": entry.confusion.tolist(),
                    "confusion_standard_error": entry.confusion_error.tolist(), "triplet_accuracy": entry.accuracy, "knn": entry.knn,
                    "linear_probe": entry.linear,
                }
                for entry in scores
            ],
        },
    )  # fmt: skip
    write_figure(draw(scores, classes), folder / "representations", test.given_by)


def gains(scores: list[RepresentationScores], classes: list[str]) -> dict[str, dict[str, float]]:
    """Return, by representation and class, the triplet accuracy less that of the raw hand-crafted metrics; empty without them."""
    base = next((entry for entry in scores if entry.name == published.HAND_CRAFTED), None)
    if base is None:
        return {}
    return {
        entry.name: dict(zip(classes, (np.diag(entry.confusion) - np.diag(base.confusion)).tolist(), strict=True))
        for entry in scores
        if entry is not base
    }


def draw(scores: list[RepresentationScores], classes: list[str]) -> Any:
    """Return a figure with a matrix for each representation."""
    from matplotlib.figure import Figure

    columns = min(3, len(scores))
    rows = -(-len(scores) // columns)
    figure = Figure(figsize=(4.2 * columns, 4.6 * rows), layout="constrained")
    axes = np.ravel(figure.subplots(rows, columns, squeeze=False))
    for axis in axes[len(scores) :]:
        axis.axis("off")
    for axis, entry in zip(axes, scores, strict=False):
        axis.imshow(entry.confusion, vmin=0, vmax=1, cmap="cividis", aspect="auto")
        axis.set_box_aspect(1)
        for (i, j), value in np.ndenumerate(entry.confusion):
            spread = entry.confusion_error[i, j]
            text = f"{value:.2f}" + (f"\n±{spread:.2f}" if np.isfinite(spread) else "")
            axis.text(j, i, text, ha="center", va="center", fontsize=8, color="black" if value > 0.5 else "white")
        axis.set_xticks(range(len(classes)), classes, rotation=40, ha="right", fontsize=8)
        axis.set_yticks(range(len(classes)), classes, fontsize=8)
        axis.set(xlabel="negative", ylabel="anchor and positive")
        axis.set_title(f"{entry.name}, {entry.runs} run{'s' * (entry.runs > 1)}\ntriplets right {entry.accuracy[0]:.3f}", fontsize=9)
    return figure


def _pair(found: tuple[FloatArray, FloatArray]) -> tuple[float, float]:
    return float(found[0]), float(found[1])

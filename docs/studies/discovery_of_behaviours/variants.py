"""Better than the paper? Each variant of a run, judged by the paper's own measures under the same budget."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from discovery.evaluation.frequency import ENOUGH, RANDOM, Found, medoids_found
from discovery.evaluation.groups import FloatArray, mean_and_error
from discovery.evaluation.tables import write_csv, write_figure, write_json
from discovery.evaluation.triplets import confusion
from discovery.representations.interface import embed_parts
from discovery.rollouts.test_set import LabelledTestSet
from discovery.saved_run import load_run
from docs.studies.discovery_of_behaviours.plan import Entry, Planned

BASE = "hand_crafted"
"""Entry whose triplet accuracy is to be beaten in every class."""
UNIQUE_WANTED, RANDOM_ALLOWED = 3, 3.0
"""Unique behaviours in every run, and random medoids of ten on average, at which the paper's measures are beaten."""


@dataclass(frozen=True)
class Variant:
    """One entry of a study, judged."""

    name: str
    kind: str
    tries: str
    overrides: tuple[str, ...]
    evaluations: list[int]
    """Of each run."""
    found: Found
    accuracy: FloatArray
    """(runs, classes) triplet accuracy by the anchor's behaviour."""

    def gains(self, base: Variant | None) -> FloatArray | None:
        """Mean triplet accuracy less that of the base, (classes,); None without a base."""
        return None if base is None else np.asarray(self.accuracy.mean(axis=0) - base.accuracy.mean(axis=0))

    def goals(self, base: Variant | None) -> dict[str, bool | None]:
        """Which of the three goals are met; None for what cannot be said, and few runs say little of the medoids."""
        gains, enough = self.gains(base), len(self.evaluations) >= ENOUGH
        return {
            "unique": min(self.found.unique) >= UNIQUE_WANTED if enough else None,
            "random": float(np.mean(self.found.count(RANDOM))) <= RANDOM_ALLOWED if enough else None,
            "triplets": None if gains is None or base is self else bool((gains > 0).all()),
        }


def judge_variants(groups: Mapping[Entry, Sequence[Planned]], test: LabelledTestSet) -> list[Variant]:
    """Judge entries by their finished runs; a run's encoder is forgotten before the next is read."""
    judged = []
    for entry, planned in groups.items():
        accuracy, evaluations, names = [], [], []
        for each in planned:
            run = load_run(each.path)
            embeddings = embed_parts(run.representation, test.parts)
            matrix = confusion(embeddings, test.labels, test.classes, run.settings.search.distance)
            accuracy.append(np.diag(matrix))
            evaluations.append(len(run.archive))
            names.append(medoids_found(entry.name, [run]).labels[0])
        judged.append(
            Variant(entry.name, entry.kind, entry.tries, entry.overrides, evaluations, Found(entry.name, names), np.stack(accuracy))
        )
    return judged


def write_variants(folder: Path, judged: Sequence[Variant], test: LabelledTestSet) -> None:
    """Write ``variants.csv``, ``.json``, ``.png`` and ``.svg``."""
    classes = test.classes
    base = next((variant for variant in judged if variant.name == BASE), None)
    entries = [_summary(variant, base, classes) for variant in judged]
    numbers = [f"triplets {name}" for name in classes]
    head = ["variant", "kind", "runs", "unique each run", "unique fewest", "unique", "unique error", "random", "random error", *numbers]
    rows = [
        [
            entry["name"], entry["kind"], entry["runs"], " ".join(map(str, entry["unique_each_run"])), entry["unique_fewest"],
            *entry["unique"], *entry["random"], *(entry["triplets"][name][0] for name in classes),
        ]
        for entry in entries
    ]  # fmt: skip
    write_csv(folder / "variants.csv", head, rows, test.given_by)
    write_json(
        folder / "variants.json",
        {
            "labels_given_by": test.given_by,
            "test_set": dict(Counter(test.labels.tolist())),
            "goals": {"unique": f"{UNIQUE_WANTED} in every run", "random": f"at most {RANDOM_ALLOWED:g} of ten on average",
                      "triplets": "above hand-crafted in every class"},
            "variants": entries,
        },
    )  # fmt: skip
    write_figure(draw(judged), folder / "variants", test.given_by)


def _summary(variant: Variant, base: Variant | None, classes: list[str]) -> dict[str, Any]:
    mean, error = mean_and_error(list(variant.accuracy))
    gains = variant.gains(base)
    return {
        "name": variant.name, "kind": variant.kind, "tries": variant.tries, "overrides": list(variant.overrides),
        "runs": len(variant.evaluations), "evaluations": variant.evaluations, **variant.found.summary(),
        "medoids": [dict(Counter(labels)) for labels in variant.found.labels],
        "triplets": {name: (float(mean[k]), float(error[k])) for k, name in enumerate(classes)},
        "gain_over_hand_crafted": None if gains is None else dict(zip(classes, gains.tolist(), strict=True)),
        "goals_met": variant.goals(base),
    }  # fmt: skip


def draw(judged: Sequence[Variant]) -> Any:
    """Return a figure: unique and random medoids of each entry, every run a point."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 0.33 * len(judged) + 1.5), layout="constrained")
    rows = np.arange(len(judged))
    panels = (("different behaviours", UNIQUE_WANTED, [v.found.unique for v in judged]),
              ("random of the medoids", RANDOM_ALLOWED, [v.found.count(RANDOM) for v in judged]))  # fmt: skip
    axes = figure.subplots(1, 2, sharey=True)
    for axis, (title, goal, values) in zip(axes, panels, strict=True):
        for row, counts in zip(rows, values, strict=True):
            jitter = np.linspace(-0.22, 0.22, len(counts)) if len(counts) > 1 else np.zeros(1)
            axis.plot(counts, row + jitter, "o", markersize=4, color="#0072b2", alpha=0.6)
            axis.plot(np.mean(counts), row, "|", markersize=15, color="#d55e00", markeredgewidth=2)
        axis.axvline(goal, color="#5c6570", linewidth=0.8, linestyle="--")
        axis.set(xlabel=f"{title}\n(each run, mean; dashed: goal)", xlim=(-0.4, None))
        axis.grid(axis="x", alpha=0.3)
    axes[0].set_yticks(rows, [variant.name for variant in judged], fontsize=8)
    axes[0].invert_yaxis()
    return figure

"""A person's answers, on disk after each of them."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from discovery.errors import DiscoveryError
from discovery.files.atomic import write_atomically
from discovery.rollouts.labels import BEHAVIOURS

UNSURE = "unsure"
KINDS = {"triples": ("first", "second", UNSURE), "labels": (*BEHAVIOURS, UNSURE)}
"""What is asked, and what may be answered."""


@dataclass
class Answers:
    """Answers to numbered questions about one set of clips."""

    path: Path
    kind: str
    """One of :data:`KINDS`."""
    fingerprint: str
    """Of the clips."""
    annotator: str
    given: list[dict[str, Any]] = field(default_factory=list)
    """Each with ``rows`` (of the clips that were shown) and ``answer``."""

    def add(self, rows: list[int], answer: str) -> None:
        """Take an answer, and write it down.

        Raises:
            DiscoveryError: For an answer that is none of the kind's.
        """
        if answer not in KINDS[self.kind]:
            raise DiscoveryError(f"answer: given {answer!r}, expected {', '.join(KINDS[self.kind])}")
        self.given.append({"rows": rows, "answer": answer})
        self._write()

    def undo(self) -> None:
        """Forget the last answer, so that its question comes again."""
        if self.given:
            self.given.pop()
            self._write()

    def _write(self) -> None:
        content: dict[str, Any] = {"kind": self.kind, "dataset": self.fingerprint, "annotators": [self.annotator], "answers": self.given}
        if self.kind == "triples":  # as triplet learning reads them
            sure = [entry for entry in self.given if entry["answer"] != UNSURE]
            turned = {"first": (0, 1, 2), "second": (0, 2, 1)}
            content["triples"] = [[entry["rows"][k] for k in turned[entry["answer"]]] for entry in sure]
        write_atomically(self.path, json.dumps(content) + "\n")


def open_answers(path: Path, kind: str, fingerprint: str, annotator: str) -> Answers:
    """Return the answers in a file, to go on from; none when there is no such file.

    Raises:
        DiscoveryError: When the file is damaged, or about something else.
    """
    answers = Answers(path, kind, fingerprint, annotator)
    if not path.exists():
        return answers
    content = _read(path)
    for what, wanted in (("kind", kind), ("dataset", fingerprint), ("annotators", [annotator])):
        if content[what] != wanted:
            raise DiscoveryError(f"{path}: has {what} {content[what]!r}, asked for is {wanted!r}; choose another file")
    answers.given = content["answers"]
    return answers


def read_labels(path: Path, fingerprint: str) -> tuple[dict[int, str], str]:
    """Return a person's labels by row, without those that they were unsure of, and their name.

    Raises:
        DiscoveryError: When the file cannot be read, or labels other clips.
    """
    content = _read(path)
    if content["kind"] != "labels" or content["dataset"] != fingerprint:
        raise DiscoveryError(f"{path}: holds {content['kind']} of {content['dataset']}, expected labels of {fingerprint}")
    return {entry["rows"][0]: entry["answer"] for entry in content["answers"] if entry["answer"] != UNSURE}, content["annotators"][0]


def _read(path: Path) -> dict[str, Any]:
    try:
        content: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        whole = content["kind"] in KINDS and all(
            entry["answer"] in KINDS[content["kind"]] and all(isinstance(row, int) for row in entry["rows"]) for entry in content["answers"]
        )
        if not whole or not isinstance(content["dataset"], str) or not content["annotators"]:
            raise ValueError("something is missing")
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DiscoveryError(f"{path}: no answers can be read ({error}); expected what the annotation page writes") from None
    return content


def question(kind: str, clips: int, number: int, seed: int) -> list[int]:
    """Return the rows that a question shows: three different ones, or one; every row once before any comes again."""
    if kind == "labels":
        lap, place = divmod(number, clips)
        return [int(np.random.default_rng([seed, lap]).permutation(clips)[place])]
    return [int(row) for row in np.random.default_rng([seed, 7, number]).choice(clips, 3, replace=False)]

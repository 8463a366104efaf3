"""How far a calibration is: a bar on the terminal, lines elsewhere."""

from __future__ import annotations

import sys
from types import TracebackType
from typing import Self

from tqdm import tqdm

MILESTONES = (
    ("fitted without part", 0.75),
    ("contact: ", 0.9),
    ("replaying", 0.93),
    ("writing the report", 0.97),
)
"""Beginnings of the lines that tell where a calibration is, and the share of its time that has passed then."""
NAMING = 0.7
"""Share of the time that goes into naming effects; how many there will be is not known, so each takes a third of what is left."""


class Progress:
    """A bar on stderr; called with a line at each step. Where stderr is no terminal, the lines alone."""

    def __init__(self) -> None:
        self._bar = tqdm(total=1.0, bar_format="{desc:<60.60} {percentage:3.0f}%|{bar}| {elapsed}", disable=not sys.stderr.isatty())
        self._share = 0.0

    def __call__(self, text: str) -> None:
        """Show a line and move the bar."""
        if self._bar.disable:
            print(f"  {text}", file=sys.stderr, flush=True)
            return
        self._share = share_after(text, self._share)
        self._bar.set_description_str(text, refresh=False)
        self._bar.n = self._share
        self._bar.refresh()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if error is None and not self._bar.disable:
            self._bar.n = 1.0
            self._bar.refresh()
        self._bar.close()


def share_after(text: str, share: float) -> float:
    """Return the share of a calibration that is done once it says ``text``; never less than ``share``."""
    for start, milestone in MILESTONES:
        if text.startswith(start):
            return max(share, milestone)
    return share + (NAMING - share) / 12 if share < NAMING else share

"""Calm output: one line per stage, and a bar with the remaining time on what takes longer than a second."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Iterator
from typing import Any

from tqdm import tqdm


def bar(total: int, what: str, unit: str, done: int = 0) -> tqdm[Any]:
    """Return a progress bar that shows itself after a second and leaves nothing behind."""
    calm = 0.2 if sys.stderr.isatty() else 5.0
    return tqdm(
        total=total, initial=done, desc=f"{what:<10}", unit=unit, unit_scale=total >= 10_000, delay=1.0, mininterval=calm,
        leave=False, dynamic_ncols=True, file=sys.stderr,
        bar_format="{desc} {percentage:3.0f} %|{bar}| {n_fmt}/{total_fmt} {unit}  {remaining} left{postfix}",
    )  # fmt: skip


class StageLine:
    """One line of output in the making."""

    def __init__(self) -> None:
        self.done = ""
        """What was done, in words."""


@contextlib.contextmanager
def stage(name: str, seconds: dict[str, float]) -> Iterator[StageLine]:
    """Time a stage; print what was done and how long it took, and add its time to ``seconds``."""
    line, start = StageLine(), time.perf_counter()
    yield line
    took = time.perf_counter() - start
    seconds[name] = round(seconds.get(name, 0.0) + took, 2)
    print(f"{name:<10} {line.done}  ({took:.1f} s)", flush=True)

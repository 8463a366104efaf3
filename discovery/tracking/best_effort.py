"""A service that fails must not end a run that it only watches."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping

import numpy as np
import numpy.typing as npt

from discovery.errors import DiscoveryError
from discovery.tracking.interface import NullTracker, Tracker


class BestEffortTracker:
    """Passes everything on to another tracker, until that fails; says so, and goes on alone.

    Args:
        name: Of the service, for people.
        make: Makes the other tracker.

    Raises:
        DiscoveryError: When it cannot even begin.
    """

    def __init__(self, name: str, make: Callable[[], Tracker]) -> None:
        self._name = name
        try:
            self._tracker = make()
        except DiscoveryError:
            raise
        except Exception as error:  # services raise what they like
            raise DiscoveryError(f"tracker={name}: {_one_line(error)}; set it up, or take tracker=tensorboard") from None

    def begin(self, stage: str) -> None:
        """Pass it on."""
        self._try(lambda: self._tracker.begin(stage))

    def log(self, stage: str, step: int, numbers: Mapping[str, float]) -> None:
        """Pass them on."""
        self._try(lambda: self._tracker.log(stage, step, numbers))

    def picture(self, stage: str, name: str, image: npt.NDArray[np.uint8]) -> None:
        """Pass it on."""
        self._try(lambda: self._tracker.picture(stage, name, image))

    def flush(self) -> None:
        """Pass it on."""
        self._try(lambda: self._tracker.flush())

    def close(self) -> None:
        """Pass it on."""
        self._try(lambda: self._tracker.close())

    def _try(self, act: Callable[[], None]) -> None:
        try:
            act()
        except DiscoveryError:  # the run folder's own trouble, such as a full disk
            raise
        except Exception as error:
            print(f"discovery: {self._name}: {_one_line(error)}; going on without it", file=sys.stderr, flush=True)
            self._tracker = NullTracker()


def _one_line(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())[:300]

"""Random numbers keyed by what they are for, so that a resumed run needs no generator's state, only counters."""

from __future__ import annotations

import zlib

import numpy as np


def seed_sequence(seed: int, purpose: str, *counters: int) -> np.random.SeedSequence:
    """Return the seed sequence of one purpose, such as ``("search", generation)``."""
    return np.random.SeedSequence([seed, zlib.crc32(purpose.encode()), *counters])


def generator(seed: int, purpose: str, *counters: int) -> np.random.Generator:
    """Return numpy's generator for one purpose."""
    return np.random.default_rng(seed_sequence(seed, purpose, *counters))


def whole_seed(seed: int, purpose: str, *counters: int) -> int:
    """Return one whole number from 0 to 2**32 - 1, for libraries that take a seed."""
    return int(seed_sequence(seed, purpose, *counters).generate_state(1, np.uint32)[0])

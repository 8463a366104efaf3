"""Keyed random draws: a number is a pure function of (world key, robot, tick, stream).

No generator state is carried along, so a draw cannot depend on thread count, batch size, chunking or how many draws
others made before. The mixing is splitmix64's finaliser (Steele, Lea and Flood 2014), applied once per key part.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from numba import uint64

from swarm_envs.compiled import compiled

# One stream per use, so that two effects of one robot in one tick draw independently.
STREAM_COMMAND_LOSS = 1
STREAM_START_KICK = 2
STREAM_MISSED = 16  # plus the sensor's index
STREAM_FALSE = 48  # plus the sensor's index
STREAM_GAINS = 80
STREAM_START_POINT = 96
STREAM_START_HEADING = 97


def world_keys(seed: int | Sequence[int], first: int, count: int) -> npt.NDArray[np.uint64]:
    """Return the keys (count,) of worlds ``first`` to ``first + count - 1`` of a batch.

    Args:
        seed: The batch's seed, or several numbers that together make it.
        first: Index of the first world.
        count: Number of worlds.
    """
    base = np.random.SeedSequence(seed).generate_state(1, np.uint64)[0]
    return mixed_keys(base, np.arange(first, first + count, dtype=np.uint64))


@compiled("uint64(uint64)")
def mix(x: Any) -> Any:
    """Scramble 64 bits so that near inputs give unrelated outputs."""
    x = uint64(x) + uint64(0x9E3779B97F4A7C15)
    x = (x ^ (x >> uint64(30))) * uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> uint64(27))) * uint64(0x94D049BB133111EB)
    return x ^ (x >> uint64(31))


@compiled()
def mixed_keys(base: int, indices: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    """Return one key per index."""
    keys = np.empty(len(indices), dtype=np.uint64)
    for i in range(len(indices)):
        keys[i] = mix(mix(base) ^ indices[i])
    return keys


@compiled("float64(uint64, int64, int64, int64)")
def uniform(key: int, robot: int, tick: int, stream: int) -> float:
    """Return a number from [0, 1)."""
    bits = mix(mix(mix(uint64(key) ^ uint64(stream)) ^ uint64(robot)) ^ uint64(tick))
    return float((bits >> uint64(11)) * (1.0 / 9007199254740992.0))


@compiled("float64(uint64, int64, int64, int64)")
def normal(key: int, robot: int, tick: int, stream: int) -> float:
    """Return a standard normal number (Box and Muller), from two draws of the stream."""
    u = 1.0 - uniform(key, robot, 2 * tick, stream)
    v = uniform(key, robot, 2 * tick + 1, stream)
    return math.sqrt(-2.0 * math.log(u)) * math.cos(2.0 * math.pi * v)

"""Old names of public things: they forward for one version, with a warning that gives the new name."""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Callable, Mapping
from typing import Any


def forwarding(module: str, names: Mapping[str, str]) -> Callable[[str], Any]:
    """Return a ``__getattr__`` for a module that forwards old names.

    Args:
        module: The module's name.
        names: Each old name with the full new one, ``package.module.name``.

    Example:
        >>> old = forwarding("swarm_envs.metrics", {"wall_edges": "swarm_envs.simulation.segments.wall_segments"})
        >>> old("wall_edge")
        Traceback (most recent call last):
        AttributeError: module 'swarm_envs.metrics' has no attribute 'wall_edge'
    """

    def get(name: str) -> Any:
        if name not in names:
            raise AttributeError(f"module {module!r} has no attribute {name!r}")
        home, _, new = names[name].rpartition(".")
        warnings.warn(f"{module}.{name} is now {names[name]}; use that", DeprecationWarning, stacklevel=2)
        return getattr(importlib.import_module(home), new)

    return get

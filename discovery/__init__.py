"""Discovery of emergent swarm behaviours: ``python -m discovery``, and :func:`load_run` for what it leaves."""

from typing import TYPE_CHECKING, Any

from discovery.errors import DiscoveryError

if TYPE_CHECKING:
    from discovery.saved_run import Medoid, Run, load_run

__all__ = ["DiscoveryError", "Medoid", "Run", "load_run"]


def __getattr__(name: str) -> Any:
    """Import what reads runs when it is asked for: its libraries take seconds, and the fleet's emergency stop needs none of them."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from discovery import saved_run

    return getattr(saved_run, name)

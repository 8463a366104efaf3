"""Discovery of emergent swarm behaviours: ``python -m discovery``, and :func:`load_run` for what it leaves."""

from discovery.errors import DiscoveryError
from discovery.saved_run import Medoid, Run, load_run

__all__ = ["DiscoveryError", "Medoid", "Run", "load_run"]

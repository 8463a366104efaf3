"""The old name of :mod:`discovery.representations.triplet`, kept for one version."""

from swarm_envs.deprecation import forwarding

__getattr__ = forwarding(__name__, {"fit_triplet": "discovery.representations.triplet.fit_triplet"})

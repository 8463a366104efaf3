"""The old name of :mod:`discovery.rollouts.dataset`, kept for one version."""

from swarm_envs.deprecation import forwarding

__getattr__ = forwarding(__name__, {"Dataset": "discovery.rollouts.dataset.Dataset"})

"""The old name of :mod:`discovery.runs.run_folder`, kept for one version."""

from swarm_envs.deprecation import forwarding

__getattr__ = forwarding(__name__, {"RunFolder": "discovery.runs.run_folder.RunFolder"})

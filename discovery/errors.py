"""The one error that a user's mistake or a machine's trouble raises."""

from __future__ import annotations


class DiscoveryError(Exception):
    """A run cannot start or go on.

    The message is one line: what was given, what was expected, what to do.
    """

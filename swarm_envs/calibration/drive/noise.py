"""The noise of measured poses: the tracker's, and the motion's own."""

from __future__ import annotations

NOISE = ("place", "heading", "along", "across", "turn")
"""Names of the noise: the tracker's in m and rad, the motion's along and across the heading in m/sqrt(s), in rad/sqrt(s)."""
PLACE, HEADING, ALONG, ACROSS, TURN = range(len(NOISE))

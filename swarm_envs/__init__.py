"""Calibrated worlds of the HeRo+ robot swarm."""

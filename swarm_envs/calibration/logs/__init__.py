"""Measured logs: what they hold, and reading them from folders and ROS bags."""

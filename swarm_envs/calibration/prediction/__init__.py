"""Prediction of a log by its commands: free-running windows, in an arena with walls and other robots, and a reference without mechanics."""

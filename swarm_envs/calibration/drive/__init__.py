"""The drive: its motion by commands alone, the likelihood of measured poses, and the effects that explain a log."""

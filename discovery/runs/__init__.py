"""The folder of one run: who may write it, what it holds, and what produced it."""

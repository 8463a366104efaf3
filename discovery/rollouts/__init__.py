"""From controllers to rollouts, and what is made of them: videos, metrics, labels, data sets."""

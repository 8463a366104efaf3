"""A page on which a person judges rollouts: which of two is more like a third, or what a single one shows."""

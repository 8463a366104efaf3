"""Contact: the likelihood of where robots end up that may touch each other or a wall, and the effects that explain it."""

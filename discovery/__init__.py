"""Discovery of emergent swarm behaviours."""

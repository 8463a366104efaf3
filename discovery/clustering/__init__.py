"""From the archive to a few behaviours: the space they are compared in, k-medoids, and whether what they find holds."""

"""How much is gained on runs that nothing was fitted to, and whether findings hold without each of the runs."""

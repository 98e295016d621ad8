"""Templates fitted to single elements: all pairs in one call."""

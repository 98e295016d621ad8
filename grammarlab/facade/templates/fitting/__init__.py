"""Templates fitted to elements one by one: all pairs in one call."""

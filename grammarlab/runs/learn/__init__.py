"""Learning a grammar, on disk: from a scenario, from labels, from finished models."""

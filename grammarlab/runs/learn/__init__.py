"""Learning of grammars on disk: from a scenario, from labels, from finished models."""

"""Symbols split by what their trees are for: from a grammar to another one, exactly."""

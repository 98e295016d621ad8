"""Grammars learned from samples or examples: parameters, mixtures, shrinkage."""

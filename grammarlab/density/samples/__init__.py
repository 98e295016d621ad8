"""Grammars learned from samples and from a few examples."""

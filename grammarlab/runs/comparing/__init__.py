"""Comparison of grammars, and traces of the derivation of a model."""

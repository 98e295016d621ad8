"""Mixtures of grammars: choices, clusters, expectation maximisation."""

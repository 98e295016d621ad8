"""Mixtures of grammars: choices, clusters, expectation and maximisation."""

"""Sizes of symbols under an alignment."""

"""Sizes of symbols that an alignment allows."""

"""Alignment of words: exact search for the cheapest matrix."""

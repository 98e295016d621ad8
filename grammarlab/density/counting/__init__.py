"""Counting of patterns: readings of preferences, drawn attributes, and automata."""

"""Repetition in a facade: kinds of columns and rows, the order of columns, storeys."""

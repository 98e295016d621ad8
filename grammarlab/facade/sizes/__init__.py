"""Sizes of a facade under constraints."""

"""Sizes of a facade under wishes: the quadratic programme, and conflicts in words."""

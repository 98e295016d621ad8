"""Grids of a facade: proposed, edited, and how they belong together."""

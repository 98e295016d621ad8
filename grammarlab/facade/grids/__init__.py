"""Grids of a facade: proposals, editing, and relations between grids."""

"""Patterns and layers inferred from a facade."""

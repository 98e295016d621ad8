"""Labelled boxes to a facade: snapped, trimmed, filled and cut."""

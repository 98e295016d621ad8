"""Gaussian processes over groups of columns."""

"""Counts of patterns in all models of a forest."""

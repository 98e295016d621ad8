"""Searches for features that explain scores."""

"""Finished curves and measurements on disk."""

"""Facades for another width or height."""

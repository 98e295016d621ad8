"""Facades of overlaid layers, each a horizontal and a vertical pattern, that fit each other at any size."""

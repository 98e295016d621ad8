"""Grids of labels in the style of an example; see README.md in this folder."""

"""Meshes of examples: walls, repeated units on rows and columns, and the label of each."""

"""Meshes and polygons cut along planes."""

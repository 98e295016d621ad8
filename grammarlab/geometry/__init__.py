"""Meshes, outlines and roofs, for whole batches."""

"""Meshes as columns: faces over points, their edges, measures and triangles."""

"""Faces, edges and vertices of meshes as separate shapes."""

"""Faces, edges and vertices of meshes as shapes of their own."""

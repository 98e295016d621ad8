"""Scenes: placed meshes, and the triangles for files and pictures."""

from grammarlab.scene.instances import Scene, realize
from grammarlab.scene.triangles import TriangleBatch, triangles

__all__ = ["Scene", "TriangleBatch", "realize", "triangles"]

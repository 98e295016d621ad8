"""Scenes: which mesh stands where, and the triangles that files and pictures are made of."""

from grammarlab.scene.instances import Scene, realize
from grammarlab.scene.triangles import TriangleBatch, triangles

__all__ = ["Scene", "TriangleBatch", "realize", "triangles"]

"""Scenes: which mesh stands where, and the triangles that files and pictures are made of."""

from grammarlab.scene.instances import Scene, realize

__all__ = ["Scene", "realize"]

"""Meshes of buildings."""

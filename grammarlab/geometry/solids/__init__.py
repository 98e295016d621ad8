"""Solids from faces, and primitive solids."""

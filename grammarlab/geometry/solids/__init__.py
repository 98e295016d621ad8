"""Solids from faces, and solids that everybody knows."""

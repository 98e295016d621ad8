"""Layered facades: patterns over symbols, their layouts and their inference."""

"""Processes that work for a session: they learn, draw and write files."""

"""Simpler functions near a preference."""

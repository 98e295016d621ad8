"""Learned densities as grammars, and their distance from the target."""

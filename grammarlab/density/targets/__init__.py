"""Densities that are wanted, and models that follow them by rejection."""

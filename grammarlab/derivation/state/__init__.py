"""Shapes under derivation as columns, and the tables that a derivation fills."""

"""Columns and tables of a derivation that runs."""

"""Finished results and derivations on disk."""

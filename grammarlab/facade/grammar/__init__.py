"""Facades, and families of them, as CGA."""

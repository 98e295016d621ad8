"""Columns of feature tables."""

"""Columns and rows more or less: every insertion and removal, ranked."""

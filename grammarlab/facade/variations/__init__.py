"""Variations with more or fewer columns and rows: all insertions and removals, ranked."""

"""Tree patterns, and their counts."""

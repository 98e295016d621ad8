"""Tables of features: one row per model, one column per feature."""

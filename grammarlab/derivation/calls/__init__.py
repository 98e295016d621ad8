"""Arguments of operations and functions."""

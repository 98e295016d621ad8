"""Kinds of elements, and the sizes that kinds share."""

"""Facades as CGA: the rules of one, and those of a family of them."""

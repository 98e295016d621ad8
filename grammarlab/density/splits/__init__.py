"""Exact splits of symbols by the states of their subtrees: from a grammar to another grammar."""

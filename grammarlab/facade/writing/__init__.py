"""Facades as CGA: grammars of a single facade, and of its family."""

"""Exact grammars: symbols split by what they count."""

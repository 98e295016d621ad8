"""Output of a match: a facade, a grammar, a picture."""

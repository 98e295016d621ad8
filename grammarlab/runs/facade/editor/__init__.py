"""A page on which a person edits a facade: what it holds, what may be done to it, and how it is served."""

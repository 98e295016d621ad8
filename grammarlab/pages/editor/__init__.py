"""The page that edits a facade."""

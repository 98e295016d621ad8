"""The page for editing a facade: document, commands, and server."""

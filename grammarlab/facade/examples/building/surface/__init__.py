"""One closed surface of the pieces of a building."""

"""One closed surface from the pieces of a building."""

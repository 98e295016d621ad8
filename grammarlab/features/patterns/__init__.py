"""Tree patterns: what a countable property of a derivation tree is."""

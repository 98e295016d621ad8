"""Tree patterns: countable properties of derivation trees."""

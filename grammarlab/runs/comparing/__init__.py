"""How far grammars are apart, and where a model came from."""

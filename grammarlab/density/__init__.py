"""Densities over the models of a grammar, and grammars that sample them; see README.md in this folder."""

"""Features of derivation trees, tables of them, and scores and acceptance rules; see README.md in this folder."""

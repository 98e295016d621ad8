"""What can be counted and measured on derivation trees, and tables of it; see README.md in this folder."""

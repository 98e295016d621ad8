"""What repeats in a facade: its columns and rows by kind, the order they come in, its storeys."""

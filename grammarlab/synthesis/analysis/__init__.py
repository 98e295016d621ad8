"""Analysis of an example: walls, rows, columns and labels."""

"""The page for correcting the analysis of an example: lines between units, labels, walls; and for trial results."""
